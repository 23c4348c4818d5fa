"""What an action did."""

from dataclasses import replace

import pytest

from arramon_client.world import Action
from arramon_server.sim.geometry import Pose
from arramon_server.sim.room import RoomCell
from arramon_server.sim.rules import Phase, State
from arramon_server.web.play.outcomes import Outcome, outcome_of, relative_heading
from tests.tiny import F, L, P, R

STREET = State(pose=Pose(0.0, 0.0, 0.0), room=(), step=4, phase_step=4)
ROOM = replace(STREET, phase=Phase.ASSEMBLY, phase_step=0)


@pytest.mark.parametrize(
    ("before", "after", "action", "expected"),
    [
        (STREET, replace(STREET, pose=Pose(0.0, 1.0, 0.0)), F, Outcome.MOVED),
        (STREET, STREET, F, Outcome.BLOCKED),
        (STREET, replace(STREET, pose=Pose(0.0, 0.0, 30.0)), R, Outcome.TURNED),
        (STREET, STREET, P, Outcome.NOTHING_IN_REACH),
        (STREET, ROOM, P, Outcome.PICKED_UP),
        (STREET, ROOM, F, Outcome.PICKED_UP),  # by the step limit
        (ROOM, replace(ROOM, square=RoomCell(2, 1)), F, Outcome.MOVED),
        (ROOM, ROOM, F, Outcome.BLOCKED),
        (ROOM, replace(ROOM, room_heading=30.0), R, Outcome.TURNED),
        (ROOM, ROOM, P, Outcome.CANNOT_PLACE),
        (ROOM, replace(STREET, turn=2), P, Outcome.PLACED),
    ],
)
def test_outcomes(before: State, after: State, action: Action, expected: Outcome) -> None:
    assert outcome_of(before, after, action) is expected


@pytest.mark.parametrize(
    ("actions", "phase_step", "expected"),
    [((), 0, 0), ((R, R, F), 3, 60), ((R, R, L, L, L), 3, 270), ((R, P), 0, 0), ((R,) * 13, 13, 30)],
)
def test_headings_are_relative_to_the_start_of_the_phase(
    actions: tuple[Action, ...], phase_step: int, expected: int
) -> None:
    assert relative_heading(actions, phase_step) == expected
