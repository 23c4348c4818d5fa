"""Metrics, compared with literal tables and with plain implementations."""

import math
import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from arramon_server.scoring.metrics import ctc_within, ndtw, placement_distance, ptc, rpod
from arramon_server.scoring.trajectory import Cell, Point3
from tests.scoring import plain
from tests.work import lines

points = st.tuples(st.floats(-60, 60), st.floats(-60, 60))
lattice = st.tuples(st.integers(0, 2).map(float), st.integers(0, 2).map(float))
paths = st.lists(points | lattice, max_size=25).map(tuple)
references = st.lists(points | lattice, min_size=1, max_size=25).map(tuple)


@settings(max_examples=200, deadline=None)
@given(paths, references)
def test_ndtw_equals_the_plain_formula(path: plain.Path, reference: plain.Path) -> None:
    assert ndtw(path, reference) == pytest.approx(plain.ndtw(path, reference), rel=0, abs=1e-9)


@pytest.mark.parametrize(("steps", "truth"), [(150, 60), (40, 39), (12, 130)])
def test_ndtw_equals_the_plain_formula_on_long_walks(steps: int, truth: int) -> None:
    draw = random.Random(steps)
    reference = walk(draw, truth, 5.0)
    near = tuple((x + draw.gauss(0, 1), z + draw.gauss(0, 1)) for x, z in walk(draw, steps, 5.0))
    for path in (near, walk(draw, steps, 180.0), near + near[::-1]):
        expected = plain.ndtw(path, reference)
        assert ndtw(path, reference) == pytest.approx(expected, rel=1e-9, abs=1e-12)


def walk(draw: random.Random, steps: int, swerve: float) -> plain.Path:
    x = z = heading = 0.0
    path = [(x, z)]
    for _ in range(steps - 1):
        heading += draw.uniform(-swerve, swerve)
        x, z = x + math.sin(math.radians(heading)), z + math.cos(math.radians(heading))
        path.append((x, z))
    return tuple(path)


@pytest.mark.parametrize(
    ("path", "reference", "expected"),
    [
        ((), ((0.0, 0.0),), 0.0),
        (((1.0, 2.0),), ((1.0, 2.0),), 1.0),
        (((0.0, 0.0), (0.0, 1.0), (0.0, 2.0)), ((0.0, 0.0), (0.0, 1.0), (0.0, 2.0)), 1.0),
        (((3.0, 0.0),), ((0.0, 0.0),), math.exp(-1)),
        (((3.0, 4.0),), ((0.0, 0.0), (3.0, 4.0)), math.exp(-5 / 6)),
        (((0.0, 0.0), (0.0, 1.0)), ((0.0, 1.0), (0.0, 0.0)), math.exp(-2 / 6)),
        # One point against many costs the distance to each of them.
        (((0.0, 0.0),), ((0.0, 1.0), (0.0, 2.0), (0.0, 3.0)), math.exp(-6 / 9)),
        # Turns and blocked moves, which repeat a position, add nothing on either side.
        (((0.0, 1.0), (0.0, 1.0), (0.0, 1.0)), ((0.0, 0.0), (0.0, 0.0)), math.exp(-1 / 3)),
        # Coming back to an earlier position is not a repetition.
        (((0.0, 0.0), (0.0, 3.0), (0.0, 0.0)), ((0.0, 0.0),), math.exp(-1)),
        (((1e6, 0.0),), ((0.0, 0.0),), 0.0),
    ],
)
def test_ndtw_matches_known_values(path: plain.Path, reference: plain.Path, expected: float) -> None:
    assert ndtw(path, reference) == pytest.approx(expected, rel=0, abs=1e-12)


def test_ndtw_uses_the_given_threshold() -> None:
    assert ndtw([(0.0, 2.0)], [(0.0, 0.0)], threshold=2.0) == pytest.approx(math.exp(-1))


def test_an_empty_reference_is_an_error() -> None:
    with pytest.raises(ValueError, match="reference path is empty"):
        ndtw([(0.0, 0.0)], [])


def test_positions_must_be_pairs() -> None:
    with pytest.raises(ValueError, match=r"\(1, 3\).*\(x, z\)"):
        ndtw([(0.0, 0.5, 1.0)], [(0.0, 0.0)])  # type: ignore[list-item]


def test_ndtw_is_vectorised() -> None:
    draw = random.Random(0)
    path, reference = walk(draw, 150, 30.0), walk(draw, 150, 30.0)
    most = 30 * (len(path) + len(reference))
    assert lines(lambda: ndtw(path, reference)) < most
    assert lines(lambda: plain.ndtw(path, reference)) > most


@pytest.mark.parametrize(
    ("final", "target", "k", "expected"),
    [
        ((0.0, 0.525, 0.0), (0.0, 0.525, 2.999), 3.0, True),
        ((0.0, 0.525, 0.0), (0.0, 0.525, 3.0), 3.0, False),  # strictly nearer
        ((0.0, 0.525, 0.0), (0.0, 0.025, 2.98), 3.0, False),  # in three dimensions: 3.0216 away, 2.98 on the ground
        ((0.0, 0.525, 0.0), (0.0, 0.025, 2.95), 3.0, True),
        ((1.0, 0.0, 0.0), (4.0, 0.0, 4.0), 5.0, False),
        ((1.0, 0.0, 0.0), (4.0, 0.0, 4.0), 7.0, True),
        (None, (0.0, 0.0, 0.0), 7.0, False),
    ],
)
def test_ctc_requires_the_target_within_k_units(final: Point3 | None, target: Point3, k: float, expected: bool) -> None:
    assert ctc_within(final, target, k) is expected


@pytest.mark.parametrize(
    ("placed", "target", "distance", "expected_rpod", "expected_ptc"),
    [
        ((2, 1, 3), (2, 1, 3), 0, 1.0, 1.0),
        ((2, 2, 3), (2, 1, 3), 1, 0.5, 0.0),
        ((1, 1, 3), (2, 1, 3), 1, 0.5, 0.0),
        ((2, 1, 1), (2, 1, 3), 2, 0.2, 0.0),
        ((1, 1, 2), (2, 2, 3), 3, 0.1, 0.0),
        ((4, 1, 0), (2, 2, 3), 6, 1 / 37, 0.0),
    ],
)
def test_placement_metrics_match_known_values(
    placed: Cell, target: Cell, distance: int, expected_rpod: float, expected_ptc: float
) -> None:
    assert placement_distance(placed, target) == placement_distance(target, placed) == distance
    assert rpod(distance) == expected_rpod
    assert ptc(distance) == expected_ptc
