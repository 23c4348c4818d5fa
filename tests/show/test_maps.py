"""Maps show what is there."""

import numpy as np

from server.episodes.plans import Plan, Street, build_section
from server.show.canvas import PINK
from server.show.maps import ROOF, STREET, ground, plan_map

PLAN = Plan("cross", "Cross", 0.0, (50.0, 20.0), (Street("Main", 6.0, ((0.0, -15.0), (0.0, 15.0))),))


def test_a_plan_s_map_has_its_streets_in_the_middle_of_free_ground() -> None:
    section = build_section(PLAN, "test")
    # Half way up the street's far half: 8 units beyond its middle.
    bare, drawn = np.asarray(ground(section, 10.0).image), np.asarray(plan_map(PLAN, section, 10.0))
    x0, _, _, z1 = section.bounds
    column, row = round((50.0 - x0 + 6) * 10), round((z1 + 6 - 8.0) * 10)
    assert tuple(bare[row, column]) == STREET
    for house in (column - 55, column + 55):
        assert (bare[row - 20 : row + 20, house] == ROOF).all(axis=-1).mean() > 0.4
    title = drawn.shape[0] - bare.shape[0]
    assert title > 0
    assert (drawn[title + row, column - 3 : column + 3] == PINK).all(axis=-1).sum() in (2, 3)
