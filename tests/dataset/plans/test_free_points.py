"""Free points: a lattice over the ground that the agent's disc can reach."""

import numpy as np
import pytest

from arramon_server.sim.section import Building, Prop, Section
from tests.dataset.plans.free_points import free_points

WALL = Building(0.0, 0.0, 0.5, 20.0, 0.0, 3.0, "brick")
"""From end to end of the section: 8 units are to its left, 4 to its right."""


def section(*props: Prop) -> Section:
    return Section("toy", 0.0, (-8.5, -3.5, 4.5, 3.5), (WALL,), props)


def test_free_points_cover_only_the_larger_side_of_a_wall() -> None:
    points = free_points(section(), 1.0)
    assert points[:, 0].tolist() == np.repeat(np.arange(-8.0, 0.0), 7).tolist()
    assert points[:, 1].tolist() == np.tile(np.arange(-3.0, 4.0), 8).tolist()


@pytest.mark.parametrize(("kind", "free"), [("banner", True), ("phone_booth", False)])
def test_solid_furniture_removes_free_points(kind: str, free: bool) -> None:
    look = ("red", "star", "white") if kind == "banner" else ("",)
    points = free_points(section(Prop(kind, -5.0, 1.0, 30.0, *look)), 1.0)
    assert ([-5.0, 1.0] in points.tolist()) is free


def test_free_points_keep_the_requested_spacing() -> None:
    points = free_points(section(), 0.5)
    assert {round(float(x) % 0.5, 9) for x in points.ravel()} == {0.0}
    assert len(points) > 3.5 * len(free_points(section(), 1.0))
