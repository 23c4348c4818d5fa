"""The ground that streets and squares cover."""

import numpy as np
import pytest

from arramon_dataset.plans import OpenSquare, Plan, Street
from arramon_dataset.plans.street_surface import inside, street_surface

BENT = Plan("bent", "Bent", 0.0, (0.0, 0.0), (Street("Bent Street", 4.0, ((0.0, -10.0), (0.0, 0.0), (10.0, 0.0))),))


@pytest.mark.parametrize(
    ("x", "z", "covered"),
    [
        (0, -9.9, True),
        (0, -10.1, False),
        (1.9, -5, True),
        (2.1, -5, False),
        (5, 1.9, True),
        (10.1, 0, False),
        (-1.9, 1.9, True),  # the outer corner of the bend
        (-2.1, 2.1, False),
    ],
)
def test_a_street_covers_its_width_and_its_bends(x: float, z: float, covered: bool) -> None:
    assert street_surface(BENT).covers(np.array([[x, z]])).tolist() == [covered]


def test_distance_is_measured_to_streets_of_one_heading() -> None:
    ground = street_surface(BENT)
    assert ground.headings == (0.0,)
    np.testing.assert_allclose(
        ground.nearest_distance(np.array([[6.0, -6.0], [5.0, 1.0], [15.0, 14.0]]), 0.0), [4, 0, 13]
    )


def test_squares_are_covered_and_add_their_edges_headings() -> None:
    triangle = OpenSquare("Triangle", ((20.0, 0.0), (30.0, 0.0), (20.0, 17.32)))
    ground = street_surface(Plan("s", "S", 90.0, (100.0, 0.0), BENT.streets, (triangle,)))
    # Across is -z where the heading is 90 degrees, along is +x.
    assert ground.covers(np.array([[101.0, -21.0], [101.0, -31.0], [116.0, -29.0]])).tolist() == [True, False, False]
    assert ground.headings == (0.0, 60.0)


def test_streets_that_are_nearly_parallel_share_a_heading() -> None:
    streets = (Street("a", 4.0, ((0.0, 0.0), (0.0, 20.0))), Street("b", 4.0, ((10.0, 0.0), (10.5, 10.0))))
    assert street_surface(Plan("p", "P", 12.0, (0.0, 0.0), streets)).headings == (12.0,)


def test_inside_handles_concave_polygons() -> None:
    corners = np.array([(0, 0), (4, 0), (4, 4), (2, 1), (0, 4)], dtype=float)
    points = np.array([(1, 1), (3, 2), (2, 2), (2, 0.5), (5, 1)], dtype=float)
    assert inside(corners, points).tolist() == [True, True, False, True, False]
