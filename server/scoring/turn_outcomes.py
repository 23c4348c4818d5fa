"""Classification of turns by their trajectories: solved, or the first thing that went wrong and where."""

from collections.abc import Sequence
from enum import StrEnum

import numpy as np

from arramon_server.scoring.episode_scores import Scores, score_turn
from arramon_server.scoring.metrics import placement_distance
from arramon_server.scoring.trajectory import Point2, TurnRecord

MAX_DEVIATION = 3.0
"""Distance from the reference path beyond which an agent has left it, in units."""

LOOK_AHEAD = 6
"""Number of reference positions, from the last one that was reached, among which the next one is looked for."""

EARLY, LATE = 0.25, 0.9
"""Shares of the reference path: a path that leaves it before the first left it at its beginning, one that follows it
up to the second reached its end."""


class PathOutcome(StrEnum):
    """How far a path followed the reference."""

    BEGAN_ELSEWHERE = "began_elsewhere"
    LEFT_AT_START = "left_at_start"
    LEFT_ON_THE_WAY = "left_on_the_way"
    REACHED_END = "reached_end"


class TurnOutcome(StrEnum):
    """Outcome of a turn: the first thing that went wrong, in the order of the task, or SOLVED.

    The values of NAVIGATION ended 3 units or more from the target, those of OBJECT nearer with another object, those of
    PLACEMENT with the target in the wrong place.
    """

    NOT_PLAYED = "not_played"
    """Its navigation did not end, or never began."""
    BEGAN_ELSEWHERE = "began_elsewhere"
    """It began off the reference path, as the turn before ended there."""
    LEFT_AT_START = "left_at_start"
    """It left the reference path in its first quarter."""
    LEFT_ON_THE_WAY = "left_on_the_way"
    """It left the reference path later."""
    PASSED_TARGET = "passed_target"
    """It followed the reference path to its end, but ended elsewhere."""
    NOT_TAKEN = "not_taken"
    """It took nothing, and a limit took another object than the target."""
    LOOK_ALIKE = "look_alike"
    """It took another object that looks like the target."""
    OTHER_OBJECT = "other_object"
    """It took an object that looks different."""
    NOT_PLACED = "not_placed"
    """It placed nothing; a limit may have."""
    ONE_CELL_OFF = "one_cell_off"
    """It placed the target in a cell beside, above or below the right one."""
    OTHER_CELL = "other_cell"
    """It placed the target further away."""
    SOLVED = "solved"


NAVIGATION = (
    TurnOutcome.NOT_PLAYED,
    TurnOutcome.BEGAN_ELSEWHERE,
    TurnOutcome.LEFT_AT_START,
    TurnOutcome.LEFT_ON_THE_WAY,
    TurnOutcome.PASSED_TARGET,
)
OBJECT = (TurnOutcome.NOT_TAKEN, TurnOutcome.LOOK_ALIKE, TurnOutcome.OTHER_OBJECT)
PLACEMENT = (TurnOutcome.NOT_PLACED, TurnOutcome.ONE_CELL_OFF, TurnOutcome.OTHER_CELL)


def followed_share(path: Sequence[Point2], reference: Sequence[Point2]) -> float:
    """Return the share of the reference along which a path was near it, in order, in [0, 1].

    Args:
        path: positions (x, z) of the agent, in order.
        reference: positions (x, z) of the ground truth, in order.
    """
    truth = np.array(reference)
    reached = 0
    for place in path:
        near = np.hypot(*(truth[reached : reached + LOOK_AHEAD] - place).T) < MAX_DEVIATION
        reached += int(np.flatnonzero(near).max(initial=0))
    return reached / max(len(truth) - 1, 1)


def path_outcome(path: Sequence[Point2], reference: Sequence[Point2]) -> PathOutcome:
    """Return how far a path, which has at least one position, followed the reference."""
    if float(np.hypot(*np.subtract(path[0], reference[0]))) > MAX_DEVIATION:
        return PathOutcome.BEGAN_ELSEWHERE
    share = followed_share(path, reference)
    if share < EARLY:
        return PathOutcome.LEFT_AT_START
    return PathOutcome.LEFT_ON_THE_WAY if share < LATE else PathOutcome.REACHED_END


def turn_outcome(turn: TurnRecord, *, took_look_alike: bool, scores: Scores | None = None) -> TurnOutcome:
    """Return the outcome of a turn.

    Args:
        turn: the turn as it was played.
        took_look_alike: whether the object that it carried has the type of the target.
        scores: scores of the turn; None to compute them.
    """
    if not turn.navigation_ended:
        return TurnOutcome.NOT_PLAYED
    scores = scores or score_turn(turn)
    if not scores["CTC-3"]:
        followed = path_outcome(turn.path, turn.reference_path)
        return TurnOutcome.PASSED_TARGET if followed is PathOutcome.REACHED_END else TurnOutcome(followed.value)
    if not turn.picked_target:
        if turn.pickup_forced:
            return TurnOutcome.NOT_TAKEN
        return TurnOutcome.LOOK_ALIKE if took_look_alike else TurnOutcome.OTHER_OBJECT
    if turn.placed_cell is None or turn.placement_forced:
        return TurnOutcome.NOT_PLACED
    distance = placement_distance(turn.placed_cell, turn.target_cell)
    return {0: TurnOutcome.SOLVED, 1: TurnOutcome.ONE_CELL_OFF}.get(distance, TurnOutcome.OTHER_CELL)
