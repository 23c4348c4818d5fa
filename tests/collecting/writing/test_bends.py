"""What writers are told of the line's bends, by tables of lines on the tiny episode."""

from collections.abc import Sequence
from dataclasses import replace

import pytest

from arramon_client.world import Action
from arramon_collecting.writing.bends import Bend, bend_of, groups_of, initial_turn
from arramon_collecting.writing.walk import Move, begin, enter, lines, moved, read_position
from arramon_server.episodes.episode import Episode
from tests import tiny

EPISODE = tiny.episode("0")
F, B, R = Move.FORWARD, Move.BACK, Move.RIGHT


def with_turns(turns: Sequence[int]) -> Episode:
    """The tiny episode, whose first line leaves its places in these headings, in turns of 30 degrees."""
    pose, path, actions = EPISODE.start, [(EPISODE.start.x, EPISODE.start.z)], list[Action]()
    for last, turn in zip((0, *turns), turns, strict=False):
        actions += [Action.RIGHT if turn > last else Action.LEFT] * abs(turn - last) + [Action.FORWARD]
        pose = replace(EPISODE.start, x=pose.x, z=pose.z, heading=(EPISODE.start.heading + 30 * turn) % 360).ahead(1.0)
        path.append((pose.x, pose.z))
    first = replace(EPISODE.turns[0], path=tuple(path), actions=tuple(actions))
    return replace(EPISODE, turns=(first, EPISODE.turns[1]))


def told(turns: Sequence[int]) -> list[Bend]:
    """What is told at each place of a line, by forward alone."""
    episode = with_turns(turns)
    position, found = begin(episode), {place: Bend() for place in range(len(turns))}
    while position.place < len(turns):
        before = position
        position, _ = moved(position, F, episode)
        bend = bend_of(before, F, position, episode)
        if bend.angle:
            found[before.place] = bend
    return list(found.values())


def test_the_writer_is_told_that_the_line_turned() -> None:
    """Turn 2 begins with a turn of 90 degrees to the right; keys that turn are no news."""
    position = enter(read_position("0.0.0.2.0.2", EPISODE), 2, EPISODE)
    bends = []
    for move in (F, F, B, B, R, R, R, R, F, F):
        before = position
        position, _ = moved(before, move, EPISODE)
        bends.append(bend_of(before, move, position, EPISODE).angle)
    assert bends == [90, 0, 0, -90, 0, 0, 0, 0, 90, 0]


@pytest.mark.parametrize(
    ("turns", "bends"),
    [
        ((0, 0, 0, 0), [0, 0, 0, 0]),
        ((0, 1, 0, 1), [0, 30, -30, 30]),  # a zigzag
        ((0, 1, 2, 3), [0, 30, 60, 90]),  # a curve
        ((0, -1, -2, -3, -4), [0, -30, -60, -90, -90]),
        ((0, 6), [0, 180]),
        ((0, 3, 2), [0, 90, -30]),  # back a little after a corner
        ((0, 3, 4, 5), [0, 90, 30, 60]),  # a curve after a corner, which was told
        ((0, 0, 1, 3), [0, 0, 30, 90]),
    ],
)
def test_single_turns_add_up_to_a_curve(turns: Sequence[int], bends: list[int]) -> None:
    assert [bend.angle for bend in told(turns)] == bends


@pytest.mark.parametrize(
    ("turns", "nets"),
    [
        ((-3, 3, 3, 3), {0: (90, False), 1: (90, True)}),  # a stub to the left, then around: a right turn
        ((-3, -3, 3, 3), {0: (90, False), 2: (90, True)}),
        ((-3, 0, 0, 0), {0: (0, False), 1: (0, True)}),  # one step aside
        ((-3, -3, -3, 0), {0: (-90, False), 3: (90, False)}),  # far enough apart to be walked one after the other
        ((0, 0, 5, 6, 6), {2: (180, False), 3: (180, True)}),
        ((0, 1, 0, 0, 3), {1: (0, False), 2: (0, True), 4: (90, False)}),
        ((1, 2, 3, 4, 5), {place: (150, place > 0) for place in range(5)}),  # a curve that goes on
    ],
)
def test_bends_that_follow_each_other_are_told_together(
    turns: Sequence[int], nets: dict[int, tuple[int, bool]]
) -> None:
    found = {place: (bend.net, bend.is_later) for place, bend in enumerate(told(turns)) if bend.angle}
    assert found == nets


def test_the_turn_to_the_object_is_told_by_itself() -> None:
    assert groups_of([0, 30, 30]) == [range(1, 2), range(2, 3)]


@pytest.mark.parametrize(
    ("turns", "angle"), [((0, 3, 3), 0), ((3, 3), 90), ((-3, 0, 0), 0), ((-3, 3, 3), 90), ((-5, -6, -6), 180)]
)
def test_the_turn_with_which_a_line_begins(turns: Sequence[int], angle: int) -> None:
    assert initial_turn(lines(with_turns(turns))[0]) == angle
