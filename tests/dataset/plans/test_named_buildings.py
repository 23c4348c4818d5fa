"""Attributes by which buildings are named."""

import pytest

from arramon_client.world import FACADES
from arramon_dataset.plans.graph import Road
from arramon_dataset.plans.junction_detection import middle_lines_of
from arramon_dataset.plans.named_buildings import COLOURS, corners_of, named_building, size_of
from arramon_dataset.plans.plan import Plan, Street
from arramon_server.sim.section import Building, Prop, Section

PLAN = Plan("x", "X", 0.0, (0.0, 0.0), (Street("Main", 6.0, ((0.0, -10.0), (0.0, 10.0))),))
ROAD = Road("street/0", "Main", "street", 6.0, ((0.0, -10.0), (0.0, 10.0)), ())
HOUSES = (Building(5.5, 0.0, 2.5, 2.0, 0.0, 8.0, "glass"), Building(12.0, 0.0, 2.0, 2.0, 0.0, 2.0, "yellow"))
SECTION = Section("x", 0.0, (-5, -10, 15, 10), HOUSES, (Prop("shop_sign", 3.0, 0.5, 270.0, shape="bank"),))


def test_a_house_at_the_road_with_a_sign() -> None:
    house = named_building(0, SECTION, (ROAD,), middle_lines_of(PLAN))
    assert (house.identity, house.look, house.colours, house.size) == ("building/0", "glass", ("blue", "grey"), "tall")
    assert (house.sign, house.roads) == ("bank", ("street/0",))
    assert house.corners == ((8.0, 2.0), (8.0, -2.0), (3.0, -2.0), (3.0, 2.0))


def test_a_house_behind_it() -> None:
    house = named_building(1, SECTION, (ROAD,), middle_lines_of(PLAN))
    assert (house.colours, house.size, house.sign, house.roads) == (("yellow",), "small", "", ())


@pytest.mark.parametrize(
    ("half", "height", "size"),
    [(2.0, 6.5, "tall"), (2.0, 6.4, ""), (2.0, 2.6, "small"), (3.0, 2.6, ""), (2.0, 2.7, "")],
)
def test_sizes(half: float, height: float, size: str) -> None:
    assert size_of(Building(0.0, 0.0, half, half, 0.0, height, "brick")) == size


def test_corners_of_a_turned_building_go_round_it() -> None:
    corners = corners_of(Building(1.0, 2.0, 3.0, 1.0, 90.0, 4.0, "red"))
    assert corners == ((2.0, -1.0), (0.0, -1.0), (0.0, 5.0), (2.0, 5.0))


def test_every_facade_has_a_colour() -> None:
    assert set(COLOURS) == set(FACADES)
