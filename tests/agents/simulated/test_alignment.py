"""Alignment of instruction rows with a path, by named things and turns."""

import math

import numpy as np
import pytest

from arramon_agents.reading.reader.slots import rows_of
from arramon_agents.simulated.alignment import current_row, places_of
from arramon_agents.simulated.courses import Course
from arramon_agents.simulated.world import StreetWorld, Things
from arramon_lang.meaning import Navigation, Rotate, Thing, Walk, Where
from arramon_server.sim.catalogue import ObjectType
from arramon_server.sim.geometry import Point
from arramon_server.sim.rules import Collectible
from arramon_server.sim.section import Building, Prop, Section

STREET = Section(
    "1",
    0.0,
    (-40.0, -40.0, 40.0, 40.0),
    (Building(17.0, 16.0, 5.0, 3.0, 0.0, 3.0, "brick"),),
    (Prop("cone", 1.0, 5.0, 0.0, "orange"), Prop("bench", 6.0, 11.0, 0.0), Prop("cone", 1.0, 9.0, 0.0, "red")),
)

PATH = np.array([*((0.0, float(z)) for z in range(11)), *((float(x), 10.0) for x in range(1, 13))])
"""Ten units ahead, then to the right."""

MUG = Thing("mug", "red", "dotted", where=(Where("near", (Thing("building", look="brick"),)),))


@pytest.fixture(scope="module")
def course() -> Course:
    world = StreetWorld(STREET)
    target = Collectible(ObjectType("dotted", "red", "mug"), Point(14.0, 0.1, 10.0))
    return Course(world, Things(world.props, [target]), (0.0, 0.0, 0.0), PATH, [target], 1, [])


@pytest.mark.parametrize(
    ("steps", "expected"),
    [
        ((Walk("past", (Thing("cone", "orange"),)), Rotate("right")), [5, 10]),
        ((Rotate("right", "at", Thing("cone", "red")), Walk("past", (Thing("bench"),))), [10, 16]),
        ((Walk("to", (Thing("cone", "red"),)), Rotate("right"), Walk("to", (Thing("bench", "brown"),))), [9, 10, 16]),
    ],
)
def test_rows_are_where_the_path_fits_them(
    course: Course, steps: tuple[Walk | Rotate, ...], expected: list[int]
) -> None:
    places = places_of(course, rows_of(Navigation(steps, MUG)))
    last = len(PATH) - 1
    np.testing.assert_allclose(places, [*expected, last, last], atol=1)


def test_a_building_is_told_by_its_facade(course: Course) -> None:
    rows = rows_of(Navigation((Walk("towards", (Thing("building", look="brick"),)), Rotate("left")), Thing("mug")))
    assert places_of(course, rows)[0] > 12
    assert places_of(course, []) == []


def test_the_current_row_is_the_first_that_is_done_later(course: Course) -> None:
    rows = rows_of(Navigation((Walk("past", (Thing("cone", "orange"),)), Rotate("right")), MUG))
    places = places_of(course, rows)
    found = [current_row(rows, places, at) for at in (0, places[0] + 1, 15, len(PATH) - 1)]
    assert found == [0, 1, 2, 2]  # Row 3 is the relation of the mug.
    assert math.isclose(course.arcs[-1], 22.0)
