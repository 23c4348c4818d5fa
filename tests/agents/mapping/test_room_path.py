"""Planning in the assembly room, checked by simulating every plan independently."""

from itertools import product

import pytest

from arramon_agents.mapping.room_path import RoomPose, plan, quarter_and_turns
from arramon_client import Action

START = RoomPose(2, 0, 0)
F, L, R = Action.FORWARD, Action.LEFT, Action.RIGHT


def walked(actions: list[Action], blocked: set[tuple[int, int]]) -> tuple[int, int, int]:
    """Where actions lead in a room of 5 columns by 4 rows: column, row, heading in degrees."""
    column, row, heading = 2, 0, 0
    for action in actions:
        if action == F:
            across, along = {0: (0, 1), 90: (1, 0), 180: (0, -1), 270: (-1, 0)}[heading]
            column, row = column + across, row + along
            assert 0 <= column <= 4
            assert 0 <= row <= 3
            assert (column, row) not in blocked
        else:
            heading = (heading + (30 if action == R else -30)) % 360
    return column, row, heading


@pytest.mark.parametrize("blocked", [set(), {(2, 1), (1, 1)}, {(1, 0), (3, 0), (2, 2), (4, 3)}])
@pytest.mark.parametrize("target", list(product(range(5), range(4))))
def test_every_target_is_faced_from_a_free_cell(target: tuple[int, int], blocked: set[tuple[int, int]]) -> None:
    actions = plan(START, target, blocked)
    assert actions is not None
    column, row, heading = walked(actions, blocked)
    across, along = {0: (0, 1), 90: (1, 0), 180: (0, -1), 270: (-1, 0)}[heading]
    assert (column + across, row + along) == target


@pytest.mark.parametrize(("target", "blocked", "steps"), [
    ((2, 1), set(), 0),
    ((2, 3), set(), 2),
    ((3, 0), set(), 3),
    ((3, 2), {(3, 1)}, 5),  # Two ahead, a quarter.
    ((2, 0), {(2, 1), (1, 0)}, 10),  # A quarter, one ahead, and about: the target is the start.
    ((2, 3), {(2, 1)}, 13),  # A quarter, one, a quarter back, three, a quarter; or mirrored.
])  # fmt: skip
def test_the_path_is_the_shortest(target: tuple[int, int], blocked: set[tuple[int, int]], steps: int) -> None:
    found = plan(START, target, blocked)
    assert found is not None
    assert len(found) == steps


def test_target_without_a_free_path_has_no_plan() -> None:
    assert plan(START, (2, 3), {(1, 0), (3, 0), (2, 1)}) is None


@pytest.mark.parametrize(("heading", "quarter", "turns"), [
    (0.0, 0, []), (270.0, 3, []), (30.0, 0, [L]), (60.0, 1, [R]), (330.0, 0, [R]), (300.0, 3, [L]),
])  # fmt: skip
def test_oblique_headings_are_turned_to_the_nearest_quarter(heading: float, quarter: int, turns: list[Action]) -> None:
    assert quarter_and_turns(heading) == (quarter, turns)
