"""Two playbacks of an episode, in step by the distance along the reference path."""

import pytest

from arramon_client.world import Action
from arramon_server.playback.alignment import PathProgress, align
from arramon_server.scoring.trajectory import Point2
from tests import tiny
from tests.playback.test_moments import playback

F, L, R, P = Action.FORWARD, Action.LEFT, Action.RIGHT, Action.INTERACT

STRAIGHT: list[Point2] = [(0.0, 0.0), (0.0, 10.0), (0.0, 20.0)]
LOOP: list[Point2] = [(0.0, 0.0), (0.0, 20.0), (10.0, 20.0), (10.0, 10.0), (-10.0, 10.0)]
"""Crosses itself at (0, 10), after 10 and after 50 units."""


@pytest.mark.parametrize(
    ("path", "places", "expected"),
    [
        (STRAIGHT, [(0, 0), (1, 3), (-2, 5)], [0, 3, 5]),
        (STRAIGHT, [(0, 5), (0, 2), (0, 6)], [5, 5, 6]),  # going back changes nothing
        (STRAIGHT, [(0, 5), (9, 9), (9, 20), (0, 20)], [5, 5, 5, 20]),  # away from the path, and back further on
        (STRAIGHT, [(50, 50)], [0]),
        (LOOP, [(0, z) for z in range(0, 21, 2)], [*range(0, 21, 2)]),  # not skipped at the crossing
        ([(3.0, 4.0)], [(3, 4), (0, 0)], [0, 0]),
        ([(0.0, 0.0), (0.0, 0.0), (0.0, 2.0)], [(0, 1)], [1]),
    ],
)
def test_progress_never_decreases(path: list[Point2], places: list[Point2], expected: list[float]) -> None:
    progress = PathProgress(path)
    assert [progress.advance(place) for place in places] == expected


def aligned(first: tuple[Action, ...], second: tuple[Action, ...]) -> list[tuple[int, int]]:
    return align(tiny.episode("0"), playback(*first).moments, playback(*second).moments)


def test_a_playback_is_in_step_with_itself() -> None:
    assert aligned(tiny.ACTIONS, tiny.ACTIONS) == [(step, step) for step in range(len(tiny.ACTIONS) + 1)]


@pytest.mark.parametrize(
    ("first", "second", "expected"),
    [
        ((F, F), (L, R, F, F), [(0, 0), (0, 1), (0, 2), (1, 3), (2, 4)]),  # waits for one that looks around
        ((F, F, P, F, P), (F, P, F, P), [(0, 0), (1, 1), (2, 1), (3, 2), (4, 3), (5, 4)]),  # waits for the same phase
        ((F, F), (), [(0, 0), (1, 0), (2, 0)]),  # one that never came so far
        ((), (), [(0, 0)]),
    ],
)
def test_steps_at_the_same_place_are_paired(
    first: tuple[Action, ...], second: tuple[Action, ...], expected: list[tuple[int, int]]
) -> None:
    assert aligned(first, second) == expected
    assert aligned(second, first) == [(one, other) for other, one in expected]


def test_every_step_of_both_is_shown_in_order() -> None:
    first, second = (F, L, L, R, F, P, F, F, P), (L, F, R, F, F, F, P, L, P, R, R)
    pairs = aligned(first, second)
    for side, actions in enumerate((first, second)):
        steps = [pair[side] for pair in pairs]
        assert steps == sorted(steps)
        assert set(steps) == set(range(len(actions) + 1))
