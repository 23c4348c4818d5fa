"""Distances from solids, and the clearance raster."""

import numpy as np
import pytest

from arramon_dataset.generation.clearance_raster import FAR, ClearanceRaster
from arramon_dataset.layout.solids import Solids
from arramon_server.sim.section import Building, Prop
from tests.dataset.generation.small_section import CROSSING

LONG = Building(10.0, 0.0, 1.0, 4.0, 90.0, 3.0, "brick")
"""Turned: 4 along x, 1 along z."""


@pytest.mark.parametrize(
    ("place", "distance"),
    [
        ((10.0, 0.0), 0.0),
        ((13.9, 0.9), 0.0),
        ((16.0, 0.0), 2.0),
        ((10.0, 3.5), 2.5),
        ((17.0, 5.0), 5.0),
        ((3.0, -5.0), 5.0),
    ],
)
def test_distance_to_a_rotated_building_is_correct(place: tuple[float, float], distance: float) -> None:
    assert Solids.from_bodies([LONG]).distance(np.array([place]))[0] == pytest.approx(distance)


def test_banners_are_not_solid_and_booths_are() -> None:
    props = [Prop("banner", 0.0, 0.0, 0.0, "red", "star", "white"), Prop("phone_booth", 5.0, 0.0, 0.0)]
    solids = Solids.from_bodies([], props)

    assert len(solids.centres) == 1
    assert solids.distance(np.array([[5.0, 1.27]]))[0] == pytest.approx(1.0)
    assert Solids.from_bodies([]).distance(np.zeros((1, 2)))[0] == np.inf


@pytest.mark.parametrize(
    ("place", "clear"),
    [
        ((0.0, -8.0), 3.0),
        ((2.0, -8.0), 1.0),
        ((-8.0, 8.0), 0.0),
        ((0.0, 12.9), 2.5),
        ((0.0, 13.5), 0.0),
        ((50, 50), 0.0),
    ],
)
def test_clearance_of_the_crossing_matches_its_geometry(place: tuple[float, float], clear: float) -> None:
    assert ClearanceRaster.of(CROSSING).clear_at(*place) == pytest.approx(min(clear, FAR / 1000), abs=0.1)
