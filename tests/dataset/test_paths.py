"""Facts about paths: legs, distances, relations as seen, and bends."""

import pytest

from arramon_client.world import bearing, turn_between
from arramon_dataset.paths import (
    PathGeometry,
    Place,
    distance_from_line,
    distance_from_segment,
    legs_of,
    max_deviation,
    offset_seen_from,
    relation_offset,
)
from tests.dataset.instructions.town import PATH


@pytest.mark.parametrize(
    ("start", "end", "degrees"),
    [((0, 0), (0, 2), 0.0), ((0, 0), (2, 0), 90.0), ((1, 1), (1, 0), 180.0), ((0, 0), (-1, 1), 315.0)],
)
def test_bearing_is_clockwise_from_north(start: tuple[float, float], end: tuple[float, float], degrees: float) -> None:
    assert bearing(start, end) == pytest.approx(degrees)


@pytest.mark.parametrize(
    ("before", "after", "turn"), [(0, 90, 90), (90, 0, -90), (350, 20, 30), (20, 350, -30), (0, 180, -180)]
)
def test_turn_takes_the_shorter_direction(before: float, after: float, turn: float) -> None:
    assert turn_between(before, after) == pytest.approx(turn)


def test_path_with_one_corner_has_two_legs() -> None:
    legs = legs_of(PATH)
    assert [(leg.start, leg.end, leg.heading, leg.length) for leg in legs] == [
        ((0.0, -15.0), (0.0, 0.0), 0.0, 15.0),
        ((0.0, 0.0), (12.0, 0.0), 90.0, 12.0),
    ]
    assert [(leg.first, leg.last) for leg in legs] == [(0, 15), (15, 27)]


def test_wiggles_and_slight_bends_are_not_corners() -> None:
    wiggle = [(0.5 * (i % 2), float(i)) for i in range(10)]
    bend = [(0.0, float(i)) for i in range(10)] + [(0.25 * i, 9.0 + i) for i in range(1, 10)]
    assert [len(legs_of(path)) for path in (wiggle, bend)] == [1, 1]


def test_stationary_path_has_no_legs() -> None:
    assert legs_of([(1.0, 1.0)]) == []


def test_max_deviation_is_the_largest_distance_from_the_line() -> None:
    assert max_deviation(PATH, 0, 15, (0.0, -15.0), (0.0, 0.0)) == 0.0
    assert max_deviation(PATH, 0, 15, (2.0, -15.0), (2.0, 0.0)) == pytest.approx(2.0)
    assert max_deviation(PATH, 0, 27, (0.0, -15.0), (12.0, 0.0)) == pytest.approx(9.37, abs=0.01)


@pytest.mark.parametrize(
    ("place", "segment", "line"), [((3.0, 5.0), 3.0, 3.0), ((0.0, 14.0), 4.0, 0.0), ((3.0, -4.0), 5.0, 3.0)]
)
def test_distance_from_a_line_does_not_end_with_the_segment(place: Place, segment: float, line: float) -> None:
    start, end = (0.0, 0.0), (0.0, 10.0)
    assert distance_from_segment(place, start, end) == pytest.approx(segment)
    assert distance_from_line(place, start, end) == pytest.approx(line)


@pytest.mark.parametrize(
    ("relation", "offset"),
    [
        ("left_of", (2.0, 1.0)),
        ("right_of", (-2.0, 1.0)),
        ("in_front_of", (1.0, 2.0)),
        ("behind", (-1.0, 2.0)),
        ("near", None),
    ],
)
def test_offset_along_a_relation(relation: str, offset: tuple[float, float] | None) -> None:
    """The viewer looks east at a place; the landmark is 1 unit behind it and 2 to its right."""
    right, behind = offset_seen_from((0.0, 0.0), (5.0, 0.0), (6.0, -2.0))
    assert relation_offset(relation, right, behind) == (offset if offset is None else pytest.approx(offset))


def test_path_bends_at_the_corner_alone() -> None:
    geometry = PathGeometry(PATH, 0.0, (14.0, 0.0))
    (corner,) = (at for at, angle in geometry.bends.items() if abs(angle) > 60.0)
    assert PATH[corner] == (0.0, 0.0)
    assert geometry.first_approach(0.5, 0.5, 0, 2.0) == geometry.nearest((0.5, 0.5), 0, len(PATH)) == corner
