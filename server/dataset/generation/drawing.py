"""Sampling of episodes without instructions in one section."""

from server.dataset.generation.draft import Draft
from server.dataset.generation.rooms import draw_decoys, draw_tasks
from server.dataset.generation.streets import Streets, draw_length
from server.dataset.randomness import seeded
from server.episodes.episode import Turn
from server.sim.catalogue import ALL_TYPES
from server.sim.section import Section

TRIES, LENGTH_DRAWS = 25, 20
"""Attempts to find paths of the drawn lengths before new lengths are drawn, and how often lengths are drawn."""


class DraftSampler:
    """Draws episode drafts in one section. Not thread-safe.

    Args:
        section: where the episodes take place.

    Raises:
        ValueError: if the section has no open ground.
    """

    def __init__(self, section: Section) -> None:
        self._section = section
        self.streets = Streets(section)

    def draw(self, episode_id: str, names: tuple[object, ...]) -> Draft:
        """Return a draft that depends on its id and `names` alone.

        Args:
            episode_id: of the episode.
            names: seed all random choices.

        Raises:
            ValueError: if the section has no paths of any of the drawn lengths.
        """
        for length_draw in range(LENGTH_DRAWS):
            random = seeded(*names, "lengths", length_draw)
            points = draw_length(random), draw_length(random)
            for attempt in range(TRIES):
                draft = self._try(episode_id, points, (*names, length_draw, attempt))
                if draft is not None:
                    return draft
        raise ValueError(f"no episode found in section {self._section.id}: it has no paths of the drawn lengths")

    def _try(self, episode_id: str, points: tuple[int, int], names: tuple[object, ...]) -> Draft | None:
        random, key = seeded(*names), "/".join(map(str, names))
        first_type, second_type = random.sample(ALL_TYPES, 2)
        start = self.streets.draw_start(random)
        first = self.streets.draw_navigation_task(key, 1, start, first_type, points[0], random)
        second = first and self.streets.draw_navigation_task(key, 2, first.end, second_type, points[1], random)
        tasks = draw_tasks(random)
        decoys = draw_decoys(key, (first_type, second_type), tasks)
        if first is None or second is None or decoys is None:
            return None
        turns = [
            Turn(navigation.path, navigation.actions, task.path, task.actions, navigation.street, task.cell)
            for navigation, task in zip((first, second), tasks, strict=True)
        ]
        return Draft(episode_id, self._section.id, start, (turns[0], turns[1]), decoys)
