"""Draws episodes without words in one section."""

from server.episodes.chance import seeded
from server.episodes.episode import Turn
from server.episodes.generate.draft import Draft
from server.episodes.generate.rooms import draw_decoys, draw_tasks
from server.episodes.generate.streets import Streets, draw_length
from server.sim.catalogue import ALL_TYPES
from server.sim.section import Section

TRIES, WISHES = 25, 20
"""How often chance may fail to find ways of the lengths wanted before others are wanted, and how often others are."""


class Drawer:
    """Draws drafts in one section. It belongs to one thread.

    Args:
        section: where.

    Raises:
        ValueError: if the section has no open ground.
    """

    def __init__(self, section: Section) -> None:
        self._section = section
        self.streets = Streets(section)

    def draw(self, episode_id: str, names: tuple[object, ...]) -> Draft:
        """A draft; the same id and names give the same.

        Args:
            episode_id: of the episode.
            names: draw everything.

        Raises:
            ValueError: if the section's ways are so few that none of the lengths wanted is found.
        """
        for wish in range(WISHES):
            random = seeded(*names, "lengths", wish)
            points = draw_length(random), draw_length(random)
            for attempt in range(TRIES):
                draft = self._try(episode_id, points, (*names, wish, attempt))
                if draft is not None:
                    return draft
        raise ValueError(f"no episode is found in section {self._section.id}: its streets are too few")

    def _try(self, episode_id: str, points: tuple[int, int], names: tuple[object, ...]) -> Draft | None:
        random, key = seeded(*names), "/".join(map(str, names))
        first_type, second_type = random.sample(ALL_TYPES, 2)
        start = self.streets.draw_start(random)
        first = self.streets.draw_errand(key, 1, start, first_type, points[0], random)
        second = first and self.streets.draw_errand(key, 2, first.end, second_type, points[1], random)
        tasks = draw_tasks(random)
        decoys = draw_decoys(key, (first_type, second_type), tasks)
        if first is None or second is None or decoys is None:
            return None
        turns = [
            Turn(errand.path, errand.actions, task.path, task.actions, errand.street, task.cell)
            for errand, task in zip((first, second), tasks, strict=True)
        ]
        return Draft(episode_id, self._section.id, start, (turns[0], turns[1]), decoys)
