"""What scoring needs to know of an episode: the recorded facts of its two turns, and nothing of the simulator."""

from dataclasses import dataclass

Point2 = tuple[float, float]
"""(x, z) on the ground, in units."""

Point3 = tuple[float, float, float]
"""(x, y, z), y up, in units."""

Cell = tuple[int, int, int]
"""(column, level, row) in the assembly room; level 1 is the floor."""


@dataclass(frozen=True, slots=True)
class TurnRecord:
    """One turn as it was played, beside what it should have been.

    Attributes:
        reference_path: the ground truth's visited positions, in order, the start included.
        target_position: centre of the target.
        target_cell: where the target belongs in the room.
        path: the agent's visited positions, in order, the start included; a turn or a blocked move may repeat a
            position. Empty where the turn was never begun.
        navigation_ended: whether the navigation phase ended, by a pick-up, at the step limit or by a clock. False where
            the episode was cut short before: such a turn scores zero.
        final_position: the agent's position when the navigation phase ended, at its recorded height (0.525 in the
            release); None where the phase did not end.
        picked_target: whether the object carried away is the target itself, however it came to be picked up.
        pickup_forced: whether a limit, not the agent, picked the object up. Recorded for whoever reads the
            results; no score depends on it (see `episode.score_turn`).
        placed_cell: where the carried object was placed; None where the assembly phase did not end.
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
    """One episode as it was played, whole or not.

    Attributes:
        episode_id: unique in the split.
        section: of the city; confidence intervals are clustered by it.
        turns: both, the second one too where it was never begun.
    """

    episode_id: str
    section: str
    turns: tuple[TurnRecord, TurnRecord]
