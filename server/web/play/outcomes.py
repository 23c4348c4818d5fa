"""What an action did, in one word, as the image shows it, too."""

from collections.abc import Sequence
from enum import Enum

from arramon_client.world import TURN_DEGREES, Action
from arramon_server.sim.rules import Phase, State


class Outcome(Enum):
    """What an action did."""

    MOVED = "moved"
    TURNED = "turned"
    BLOCKED = "blocked"
    NOTHING_IN_REACH = "nothing_in_reach"
    CANNOT_PLACE = "cannot_place"
    PICKED_UP = "picked_up"
    PLACED = "placed"


def outcome_of(before: State, after: State, action: Action) -> Outcome:
    """Return what an action did.

    Args:
        before: the state in which it was taken.
        after: the next state.
        action: the action.
    """
    if after.phase is not before.phase or after.turn != before.turn:
        return Outcome.PICKED_UP if after.phase is Phase.ASSEMBLY else Outcome.PLACED
    if action in (Action.LEFT, Action.RIGHT):
        return Outcome.TURNED
    if action is Action.INTERACT:
        return Outcome.NOTHING_IN_REACH if after.phase is Phase.NAVIGATION else Outcome.CANNOT_PLACE
    stayed = (before.pose, before.square) == (after.pose, after.square)
    return Outcome.BLOCKED if stayed else Outcome.MOVED


def relative_heading(actions: Sequence[Action], phase_step: int) -> int:
    """Return the heading relative to the start of the phase, in degrees clockwise in [0, 360).

    Args:
        actions: all actions of the episode so far.
        phase_step: the number of those in the current phase.
    """
    recent = actions[len(actions) - phase_step :]
    return TURN_DEGREES * (recent.count(Action.RIGHT) - recent.count(Action.LEFT)) % 360
