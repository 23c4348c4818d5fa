"""Furniture along buildings of several headings: outside walls, with banners that face the street."""

import math
from functools import cache
from itertools import combinations

import numpy as np
import pytest

from arramon_client.world import BANNER_COLOURS, BANNER_SHAPES, SHOPS
from arramon_dataset.layout.grid import Points
from arramon_dataset.plans import Plan, Street, build_section
from arramon_dataset.plans.street_furniture import COUNTS, crossings
from arramon_server.sim.assets.furniture import COLOURS, piece_of
from arramon_server.sim.section import ON_WALLS, Building, Prop, Section

SLANTED = Plan(
    "slanted",
    "Slanted",
    17.0,
    (5.0, -3.0),
    (
        Street("Long Street", 6.0, ((0.0, -18.0), (0.0, 18.0))),
        Street("Slant", 5.0, ((-15.0, -9.0), (14.0, 7.74))),
        Street("Alley", 2.4, ((-14.0, 12.0), (0.0, 10.0))),
    ),
)


@cache
def slanted() -> Section:
    return build_section(SLANTED, "test")


def depth(building: Building, points: Points) -> Points:
    """(n,): how far points (n, 2) are inside a building; negative outside."""
    angle = math.radians(building.heading)
    dx, dz = (points - [building.x, building.z]).T
    across = building.half_width - np.abs(dx * math.cos(angle) - dz * math.sin(angle))
    along = building.half_length - np.abs(dx * math.sin(angle) + dz * math.cos(angle))
    inside: Points = np.minimum(across, along)
    return inside


def footprint(prop: Prop) -> Points:
    """(4, 2): the corners of what stands in the way."""
    collider = piece_of(prop.kind, prop.colour).collider
    assert collider
    angle = math.radians(prop.heading)
    right, ahead = np.array([math.cos(angle), -math.sin(angle)]), np.array([math.sin(angle), math.cos(angle)])
    signs = ((-1, -1), (-1, 1), (1, 1), (1, -1))
    corners: Points = np.array(
        [[prop.x, prop.z] + a * collider.half_width * right + b * collider.half_length * ahead for a, b in signs]
    )
    return corners


def test_slanted_section_has_buildings_of_three_headings() -> None:
    assert len({building.heading for building in slanted().buildings}) == 3


def standing() -> list[Prop]:
    return [prop for prop in slanted().props if prop.kind not in (*ON_WALLS, "zebra_crossing")]


def test_furniture_does_not_overlap_buildings() -> None:
    assert len(standing()) > 50
    for prop in standing():
        for building in slanted().buildings:
            assert depth(building, footprint(prop)).max() < 0.002, (prop, building)


def test_furniture_pieces_keep_their_distance() -> None:
    places = [(prop.x, prop.z) for prop in standing()]
    assert min(math.dist(one, other) for one, other in combinations(places, 2)) > 0.7


def test_what_hangs_hangs_on_a_wall_and_faces_the_street() -> None:
    hanging = [prop for prop in slanted().props if prop.kind in ON_WALLS]
    assert {prop.kind for prop in hanging} == ON_WALLS
    for banner in hanging:
        place = np.array([[banner.x, banner.z]])
        angle = math.radians(banner.heading)
        before = place + 0.4 * np.array([math.sin(angle), math.cos(angle)])
        assert min(abs(float(depth(building, place)[0])) for building in slanted().buildings) < 0.002
        assert max(float(depth(building, before)[0]) for building in slanted().buildings) < 0.0


def test_banners_and_signs_show_something() -> None:
    banners = [prop for prop in slanted().props if prop.kind == "banner"]
    assert len(banners) >= 12
    for banner in banners:
        assert banner.colour in BANNER_COLOURS
        assert banner.shape in BANNER_SHAPES
        assert banner.shape_colour != banner.colour
    signs = [prop for prop in slanted().props if prop.kind == "shop_sign"]
    assert {sign.shape for sign in signs} == set(SHOPS)


def test_zebra_crossings_lie_across_wide_streets_that_leave_a_junction() -> None:
    zebras = [prop for prop in slanted().props if prop.kind == "zebra_crossing"]
    assert zebras
    meetings = crossings(SLANTED)
    for zebra in zebras:
        place = np.array([zebra.x, zebra.z])
        assert 2.0 < np.hypot(*(meetings - place).T).min() < 8.0
        along = [abs((zebra.heading - SLANTED.heading) % 90.0) < 0.5, abs((zebra.heading - 77.0) % 90.0) < 0.5]
        assert any(along), zebra


def test_crossings_are_where_street_lines_meet() -> None:
    found = sorted((round(x), round(z)) for x, z in crossings(SLANTED).tolist())
    assert len(found) == 2
    middle = SLANTED.world(np.array([[0.0, -0.34]]))[0]
    assert min(math.dist(middle, place) for place in crossings(SLANTED).tolist()) < 0.6


@pytest.mark.parametrize("kind", COLOURS)
def test_furniture_kinds_appear_in_several_colours(kind: str) -> None:
    seen = {prop.colour for prop in slanted().props if prop.kind == kind}
    assert seen == set(COLOURS[kind]) if COUNTS[kind] > 6 else len(seen) >= 2
