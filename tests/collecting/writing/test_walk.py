"""How a writer walks, by tables of moves on the tiny episode, whose turn 2 begins with a turn of 90 degrees."""

from collections.abc import Sequence

import pytest
from hypothesis import given
from hypothesis import strategies as st

from arramon_client.world import Action, bearing
from arramon_collecting.writing.walk import (
    DONE,
    Move,
    Position,
    begin,
    enter,
    lines,
    moved,
    preview,
    read_position,
    room_before,
    state_at,
    target_bearing,
)
from arramon_collecting.writing.walk import (
    Outcome as Did,
)
from arramon_server.errors import BadInput
from arramon_server.sim.room import RoomCell
from arramon_server.sim.rules import Phase, PlacedObject
from arramon_server.sim.rules import moved as walked
from arramon_server.web.play.practice_split import practice_split
from tests import tiny

EPISODE = tiny.episode("0")
F, B, L, R, ACT = Move.FORWARD, Move.BACK, Move.LEFT, Move.RIGHT, Move.ACT


def walk(moves: Sequence[Move], position: Position | None = None) -> tuple[Position, list[Did]]:
    position, outcomes = position or begin(EPISODE), []
    for move in moves:
        position, outcome = moved(position, move, EPISODE)
        outcomes.append(outcome)
    return position, outcomes


@pytest.mark.parametrize(
    ("moves", "end", "outcomes"),
    [
        ((F, F, F), "0.2.0.2.0.0", [Did.MOVED, Did.MOVED, Did.AT_TARGET]),
        ((B,), "0.0.0.2.0.0", [Did.AT_START]),
        ((F, B, B), "0.0.0.2.0.0", [Did.MOVED, Did.MOVED, Did.AT_START]),
        ((ACT,), "0.0.0.2.0.0", [Did.NOT_THERE_YET]),
        ((L,) * 12, "0.0.0.2.0.0", [Did.TURNED] * 12),
        ((R, F), "0.1.0.2.0.0", [Did.TURNED, Did.MOVED]),  # within one turn of the line
        ((R, R, F, F), "0.1.0.2.0.0", [Did.TURNED, Did.TURNED, Did.FACED_LINE, Did.MOVED]),
        ((F, R, R, R, B), "0.0.0.2.0.0", [Did.MOVED, Did.TURNED, Did.TURNED, Did.TURNED, Did.MOVED]),
        ((F, F, L, F), "0.2.0.2.0.0", [Did.MOVED, Did.MOVED, Did.TURNED, Did.FACED_LINE]),
        ((F, F, ACT), "1.0.0.2.0.1", [Did.MOVED, Did.MOVED, Did.PICKED_UP]),
        ((F, F, R, ACT), "1.0.0.2.0.1", [Did.MOVED, Did.MOVED, Did.TURNED, Did.PICKED_UP]),
    ],
)
def test_street(moves: Sequence[Move], end: str, outcomes: list[Did]) -> None:
    position, found = walk(moves)
    assert (str(position), found) == (end, outcomes)


@pytest.mark.parametrize(("position", "shown"), [("0.1.3.2.0.0", "1.0.0.2.0.0"), ("1.0.3.1.2.1", "0.2.0.2.0.1")])
def test_the_preview_is_the_other_phase(position: str, shown: str) -> None:
    assert str(preview(read_position(position, EPISODE), EPISODE)) == shown


@pytest.mark.parametrize(
    ("moves", "end", "outcomes"),
    [
        ((F, F, F, F), "1.0.0.2.3.1", [Did.MOVED, Did.MOVED, Did.MOVED, Did.BLOCKED]),
        ((B,), "1.0.0.2.0.1", [Did.BLOCKED]),
        ((F, B), "1.0.0.2.0.1", [Did.MOVED, Did.MOVED]),
        ((L, F, ACT), "1.0.11.2.0.1", [Did.TURNED, Did.BLOCKED, Did.CANNOT_PLACE]),
        (
            (R, R, R, F, F, F, ACT),
            "1.0.3.4.0.1",
            [*[Did.TURNED] * 3, Did.MOVED, Did.MOVED, Did.BLOCKED, Did.CANNOT_PLACE],
        ),
        # Placed elsewhere than the ground truth has it: the street goes on all the same.
        ((ACT,), "2.0.0.2.0.2", [Did.PLACED]),
        ((R, R, R, ACT), "2.0.0.2.0.2", [*[Did.TURNED] * 3, Did.PLACED]),
    ],
)
def test_room(moves: Sequence[Move], end: str, outcomes: list[Did]) -> None:
    position, found = walk(moves, enter(read_position("0.0.0.2.0.1", EPISODE), 1, EPISODE))
    assert (str(position), found) == (end, outcomes)


@pytest.mark.parametrize("placing", [(ACT,), (R, R, R, ACT), (F, F, L, L, L, ACT)])
def test_wherever_the_object_is_put_it_lands_right(placing: Sequence[Move]) -> None:
    position, _ = walk((F, F, ACT, *placing))
    room = state_at(position, EPISODE).room
    assert [(item.type, tuple(item.placement)) for item in room[1:]] == [(tiny.TARGETS[0], (2, 1, 2))]
    assert room == room_before(EPISODE, 2)


def test_turn_2_begins_where_turn_1_ends_and_the_last_placing_finishes() -> None:
    position, _ = walk((F, F, ACT, ACT))
    state = state_at(position, EPISODE)
    assert (state.pose.x, state.pose.z, state.pose.heading, state.turn) == (0.0, 2.0, 0.0, 2)
    position, outcomes = walk((F, F, F, ACT, ACT), position)
    assert outcomes == [Did.FACED_LINE, Did.MOVED, Did.MOVED, Did.PICKED_UP, Did.FINISHED]
    assert (position.part, position.reached) == (3, DONE)
    seen, goal = state_at(position, EPISODE), EPISODE.turns[1].target_cell
    assert (position.is_placed, target_bearing(position, EPISODE), seen.carried) == (True, None, None)
    assert seen.room == (*room_before(EPISODE, 2), PlacedObject(tiny.TARGETS[1], goal))
    assert abs(bearing(seen.square, (goal.column, goal.row)) - seen.room_heading) <= 15.0
    assert read_position(str(position), EPISODE) == position
    assert not enter(position, 3, EPISODE).is_placed, "the place is shown again to whoever goes on writing"
    again = enter(position, 0, EPISODE)
    assert (str(again), walk((F, F, ACT), again)[0].reached) == ("0.0.0.2.0.4", DONE)


@pytest.mark.parametrize("episode", practice_split().episodes.values(), ids=lambda episode: episode.episode_id)
def test_the_line_is_the_ground_truth(episode: object) -> None:
    """By forward alone the writer sees every place of the ground truth in the heading in which it is left."""
    assert isinstance(episode, type(EPISODE))
    pose = episode.start
    for turn, line in zip(episode.turns, lines(episode), strict=True):
        left = []
        for action in turn.actions:
            if action is Action.FORWARD:
                left.append(pose.heading)
            pose = walked(pose, action)
        left.append(pose.heading)
        headings = [(episode.start.heading + 30.0 * turned) % 360.0 for turned in line.headings]
        assert headings == pytest.approx(left)
        assert len(line.places) == len(line.headings)


@pytest.mark.parametrize(
    ("position", "bearing"),
    [
        ("0.0.0.2.0.0", 0.0),
        ("0.0.3.2.0.0", 270.0),
        ("2.0.0.2.0.2", 90.0),
        ("1.0.0.2.0.1", 0.0),
        ("1.0.3.1.2.1", 0.0),
        ("1.0.0.4.2.1", 270.0),
        ("1.0.0.2.2.1", None),
    ],
)
def test_the_arrow_points_to_the_target(position: str, bearing: float | None) -> None:
    found = target_bearing(read_position(position, EPISODE), EPISODE)
    assert found == (bearing if bearing is None else pytest.approx(bearing))


@pytest.mark.parametrize(
    "text",
    ["", "0.0.0.2.0", "0.0.0.2.0.0.0", "a.0.0.2.0.0", "4.0.0.2.0.4", "1.0.0.2.0.0", "0.3.0.2.0.0", "0.0.12.2.0.0",
     "1.1.0.2.0.1", "1.0.0.5.0.1", "0.0.0.2.0.5", "0.0.0.2.0.-1", "9" * 60],
)  # fmt: skip
def test_positions_that_are_none_are_refused(text: str) -> None:
    with pytest.raises(BadInput, match="position"):
        read_position(text, EPISODE)


def test_parts_that_were_not_reached_cannot_be_entered() -> None:
    with pytest.raises(BadInput, match="part 1 has not been reached; expected 0 to 0"):
        enter(begin(EPISODE), 1, EPISODE)


def test_state_in_the_room_carries_the_target() -> None:
    state = state_at(Position(3, 0, 3, RoomCell(1, 2), 3), EPISODE)
    assert (state.phase, state.carried, state.square, state.room_heading) == (
        Phase.ASSEMBLY,
        tiny.TARGETS[1],
        RoomCell(1, 2),
        90.0,
    )


@given(st.lists(st.sampled_from(list(Move)), max_size=60))
def test_every_walk_stays_on_the_line_and_in_the_room(moves: list[Move]) -> None:
    position = begin(EPISODE)
    for move in moves:
        before = position
        position, _ = moved(position, move, EPISODE)
        assert read_position(str(position), EPISODE) == position
        assert position.reached >= before.reached
        assert position.part in (before.part, before.part + 1)
        assert state_at(position, EPISODE).room == room_before(EPISODE, position.turn)
