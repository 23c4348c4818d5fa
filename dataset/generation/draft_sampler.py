"""Random sampling of episode drafts in one section."""

from dataclasses import dataclass

from arramon_dataset.generation.assembly_tasks import AssemblyTask, draw_decoys, draw_tasks
from arramon_dataset.generation.draft import Draft
from arramon_dataset.generation.navigation_tasks import NavigationTask, NavigationTaskSampler, draw_length
from arramon_dataset.randomness import seeded
from arramon_server.episodes.episode import Turn
from arramon_server.sim.catalogue import ALL_TYPES, ObjectType
from arramon_server.sim.geometry import Pose
from arramon_server.sim.rules import PlacedObject
from arramon_server.sim.section import Section

TRIES, LENGTH_DRAWS = 25, 20
"""Attempts to find a path of the drawn length before a new length is drawn, and how often lengths are drawn."""

SECOND_TRIES = 2
"""Attempts for the second turn, whose start is fixed, so that more attempts find little more."""


@dataclass(frozen=True, slots=True)
class PartialDraft:
    """A draft without the path of its second turn.

    Attributes:
        start: pose at the beginning of turn 1.
        turn: turn 1.
        end: pose at its end.
        second_type: type of the object to pick up in turn 2.
        second_task: where to place it.
        decoys: objects in the room.
    """

    start: Pose
    turn: Turn
    end: Pose
    second_type: ObjectType
    second_task: AssemblyTask
    decoys: tuple[PlacedObject, ...]


class DraftSampler:
    """Samples episode drafts in one section. Not thread-safe.

    Args:
        section: where the episodes take place.

    Raises:
        ValueError: if the section has no open ground.
    """

    def __init__(self, section: Section) -> None:
        self._section = section
        self.streets = NavigationTaskSampler(section)

    def draw(self, episode_id: str, names: tuple[object, ...]) -> Draft:
        """Return a complete draft, determined by the id and the seed `names` alone.

        Args:
            episode_id: of the episode.
            names: seed of all random choices.

        Raises:
            ValueError: if the section has no paths of any of the drawn lengths.
        """
        for attempt in range(TRIES):
            draft = self.complete(self.begin((*names, attempt)), episode_id, (*names, attempt, "second"))
            if draft is not None:
                return draft
        raise self._no_paths()

    def begin(self, names: tuple[object, ...]) -> PartialDraft:
        """Return a draft without its second path, determined by the seed `names` alone.

        Raises:
            ValueError: if the section has no paths of any of the drawn lengths.
        """
        for length_draw in range(LENGTH_DRAWS):
            points = draw_length(seeded(*names, "length", length_draw))
            for attempt in range(TRIES):
                found = self._try_beginning(points, (*names, length_draw, attempt))
                if found is not None:
                    return found
        raise self._no_paths()

    def complete(self, beginning: PartialDraft, episode_id: str, names: tuple[object, ...]) -> Draft | None:
        """Return the draft completed with a second turn, or None if no path was found; deterministic."""
        for length_draw in range(LENGTH_DRAWS):
            points = draw_length(seeded(*names, "length", length_draw))
            for attempt in range(SECOND_TRIES):
                key = (*names, length_draw, attempt)
                second = self.streets.draw_navigation_task(
                    _joined(key), 2, beginning.end, beginning.second_type, points, seeded(*key)
                )
                if second is not None:
                    turns = beginning.turn, _turn(second, beginning.second_task)
                    return Draft(episode_id, self._section.id, beginning.start, turns, beginning.decoys)
        return None

    def _try_beginning(self, points: int, names: tuple[object, ...]) -> PartialDraft | None:
        random, key = seeded(*names), _joined(names)
        first_type, second_type = random.sample(ALL_TYPES, 2)
        start = self.streets.draw_start(random)
        first = self.streets.draw_navigation_task(key, 1, start, first_type, points, random)
        tasks = draw_tasks(random)
        decoys = None if first is None else draw_decoys(key, (first_type, second_type), tasks)
        if first is None or decoys is None:
            return None
        return PartialDraft(start, _turn(first, tasks[0]), first.end, second_type, tasks[1], decoys)

    def _no_paths(self) -> ValueError:
        return ValueError(f"no episode found in section {self._section.id}: it has no paths of the drawn lengths")


def _joined(names: tuple[object, ...]) -> str:
    return "/".join(map(str, names))


def _turn(navigation: NavigationTask, task: AssemblyTask) -> Turn:
    return Turn(navigation.path, navigation.actions, task.path, task.actions, navigation.street, task.cell)
