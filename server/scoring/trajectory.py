"""Records of played episodes and turns: the input of scoring, independent of the simulator."""

from dataclasses import dataclass

Point2 = tuple[float, float]
"""Position (x, z) on the ground, in units."""

Point3 = tuple[float, float, float]
"""Position (x, y, z), y up, in units."""

Cell = tuple[int, int, int]
"""Cell (column, level, row) of the assembly room; level 1 is the floor."""


@dataclass(frozen=True, slots=True)
class TurnRecord:
    """One turn as it was played, with the ground truth.

    Attributes:
        reference_path: positions of the ground truth, in order, including the start.
        target_position: centre of the target.
        target_cell: cell of the room to which the target belongs.
        path: positions of the agent, in order, including the start; a rotation or a blocked move may repeat a position.
            Empty if the turn was never begun.
        navigation_ended: whether the navigation phase ended, by a pick-up, at the step limit or by a clock. False if
            the episode ended before: such a turn scores zero.
        final_position: position of the agent when the navigation phase ended, at its recorded height (0.525 in the
            release); None if the phase did not end.
        picked_target: whether the carried object is the target, whether the agent or a limit picked it up.
        pickup_forced: whether a limit, not the agent, picked the object up. For information only; no score depends on
            it (see `episode_scores.score_turn`).
        placed_cell: cell in which the carried object was placed; None if the assembly phase did not end.
        placement_forced: whether a limit, not the agent, placed it.
    """

    reference_path: tuple[Point2, ...]
    target_position: Point3
    target_cell: Cell
    path: tuple[Point2, ...] = ()
    navigation_ended: bool = False
    final_position: Point3 | None = None
    picked_target: bool = False
    pickup_forced: bool = False
    placed_cell: Cell | None = None
    placement_forced: bool = False


@dataclass(frozen=True, slots=True)
class EpisodeRecord:
    """One episode as it was played, completely or in part.

    Attributes:
        episode_id: id of the episode, unique in the split.
        section: section of the city; confidence intervals condition on the sections.
        turns: records of both turns, also of a second turn that was never begun.
    """

    episode_id: str
    section: str
    turns: tuple[TurnRecord, TurnRecord]
