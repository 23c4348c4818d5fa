"""Maps show what is there."""

import numpy as np

from server.episodes.plans import Plan, Street, build_section
from server.show.maps import ROOF, STREET, ground

PLAN = Plan("cross", "Cross", 0.0, (50.0, 20.0), (Street("Main", 6.0, ((0.0, -15.0), (0.0, 15.0))),))


def test_the_ground_is_free_along_a_street_and_built_up_beside_it() -> None:
    section = build_section(PLAN, "test")
    # Half way up the street's far half: 8 units beyond its middle.
    drawn = np.asarray(ground(section, 10.0).image)
    x0, _, _, z1 = section.bounds
    column, row = round((50.0 - x0 + 6) * 10), round((z1 + 6 - 8.0) * 10)
    assert tuple(drawn[row, column]) == STREET
    for house in (column - 55, column + 55):
        assert (drawn[row - 20 : row + 20, house] == ROOF).all(axis=-1).mean() > 0.4
