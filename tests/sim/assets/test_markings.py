"""Road markings: dashes along the middle of roads, and nowhere else."""

from dataclasses import replace
from itertools import combinations, pairwise
from math import cos, hypot, radians, sin

import pytest

from arramon_server.sim.assets.markings import DASH, SHORTEST, Dash, dashes
from arramon_server.sim.section import Building, Section

SIN, COS = sin(radians(30.0)), cos(radians(30.0))


def street(width: float, heading: float = 0.0, length: float = 20.0) -> Section:
    """Two rows of houses along +z, 10 deep, with a street of this width between them that ends in a wall."""
    sides = [Building(x * (width / 2 + 5.0), 0.0, 5.0, length / 2, 0.0, 3.0, "brick") for x in (-1, 1)]
    return Section("street", heading, (-10.0, -10.0, 10.0, 10.0), tuple(sides), ())


def test_streets_have_dashes_along_their_middle() -> None:
    found = dashes(street(6.0), pavement=0.8)
    assert len(found) == 10
    assert {round(abs(dash.x) / 0.26) for dash in found} <= {0, 1}
    assert {dash.heading for dash in found} == {0.0}
    ahead = sorted(dash.z for dash in found)
    assert {round(b - a, 6) for a, b in pairwise(ahead)} == {2.0}
    assert ahead[0] >= -10.8 + DASH / 2
    assert ahead[-1] <= 10.8


def test_streets_across_the_section_have_dashes_along_themselves() -> None:
    assert {dash.heading for dash in dashes(street(6.0, heading=90.0), pavement=0.8)} == {180.0}


@pytest.mark.parametrize("width", [2.5, 4.0, 14.0])
def test_alleys_and_squares_have_no_dashes(width: float) -> None:
    assert dashes(street(width), pavement=0.8) == []


def test_short_streets_have_no_dashes() -> None:
    assert dashes(street(6.0, length=SHORTEST - 2.5), pavement=0.8) == []


def test_section_without_buildings_has_no_dashes() -> None:
    assert dashes(Section("bare", 0.0, (0, 0, 20, 20), (), ()), pavement=0.8) == []


def test_dashes_turn_with_the_section() -> None:
    straight = dashes(street(6.0), pavement=0.8)
    assert all(isinstance(dash, Dash) for dash in straight)
    turned = dashes(
        Section(
            "turned",
            90.0,
            (-10.0, -10.0, 10.0, 10.0),
            tuple(Building(0.0, -s * 8.0, 5.0, 10.0, 90.0, 3.0, "brick") for s in (-1, 1)),
            (),
        ),
        pavement=0.8,
    )
    assert len(turned) == len(straight)
    assert all(abs(dash.z) <= 0.5 for dash in turned)


def test_oblique_streets_have_dashes_that_cross_no_others() -> None:
    straight = street(6.0)
    turned = replace(straight.buildings[0], x=30.0 - 8.0 * COS, z=8.0 * SIN, heading=30.0)
    across = replace(turned, x=30.0 + 8.0 * COS, z=-8.0 * SIN)
    both = replace(straight, bounds=(-10, -20, 45, 20), buildings=(*straight.buildings, turned, across))
    found = dashes(both, pavement=0.8)
    slanting = [dash for dash in found if dash.heading == 30.0 and dash.x > 15.0]
    assert len(slanting) in (10, 11)
    for dash in slanting:
        assert abs((dash.x - 30.0) * COS - dash.z * SIN) <= 0.51
    assert all(hypot(one.x - other.x, one.z - other.z) > 1.0 for one, other in combinations(found, 2))
