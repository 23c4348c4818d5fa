"""Rewards: the remaining distance along a path."""

import pytest

from arramon_dataset.environments.rewards import ReferencePath

CORNER = ((0.0, 0.0), (0.0, 2.0), (3.0, 2.0))
LOOP = ((0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0), (0.0, 0.0))

LEFT = [
    (CORNER, (0.0, 0.0), 5.0),
    (CORNER, (0.0, 1.5), 3.5),
    (CORNER, (0.0, 2.0), 3.0),
    (CORNER, (3.0, 2.0), 0.0),
    (CORNER, (-1.0, 1.0), 5.0),  # one off, and four from there
    (CORNER, (3.0, 4.0), 2.0),
    (CORNER, (2.0, 1.5), 1.5),
    (LOOP, (0.0, 0.0), 0.0),  # of two nearest points, the last
    (((1.0, 1.0),), (1.0, 3.0), 2.0),
]


@pytest.mark.parametrize(("points", "place", "expected"), LEFT)
def test_distance_left(points: tuple[tuple[float, float], ...], place: tuple[float, float], expected: float) -> None:
    assert ReferencePath(points).remaining(*place) == pytest.approx(expected)


def test_length() -> None:
    assert ReferencePath(CORNER).length == 5.0
    assert ReferencePath(((1.0, 1.0),)).length == 0.0
