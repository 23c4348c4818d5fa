"""The choice of what checks collisions, and that it never matters: pybullet and plane geometry decide alike."""

import sys

import pytest

from arramon_server.sim.cameras import CAMERAS
from arramon_server.sim.city import city_scene
from arramon_server.sim.footprints import TOUCHING, Footprints
from arramon_server.sim.physics import has_pybullet, physics_of, problem_of_camera
from tests.dataset.plans.sections import ALL, section_of
from tests.physics import Obstacles, needs_pybullet

MOVES = 100_000
"""Moves in all sections together; `benchmarks.simulation.collisions` makes millions."""


@needs_pybullet
@pytest.mark.parametrize("section_id", ALL)
def test_pybullet_and_plane_geometry_never_decide_differently(section_id: str) -> None:
    from benchmarks.simulation.collisions import compare_in_section

    moves = MOVES // len(ALL)
    counts = compare_in_section(section_of(section_id), moves, 0)
    assert counts.moves == moves
    assert counts.near > 0.33 * moves
    assert 0.3 * moves < counts.free < 0.7 * moves
    assert counts.differ == 0
    # The test can fail: by itself pybullet decides otherwise, but never far from touching.
    assert counts.pybullet_alone > 0.01 * moves
    assert counts.farthest < TOUCHING / 2


@needs_pybullet
def test_pybullet_checks_collisions_where_it_is_installed() -> None:
    physics = physics_of(city_scene(section_of("1")))
    assert isinstance(physics, Obstacles)
    physics.close()


def test_plane_geometry_checks_collisions_elsewhere(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pybullet", None)
    assert not has_pybullet()
    physics = physics_of(city_scene(section_of("1")))
    assert isinstance(physics, Footprints)
    physics.close()


def test_the_reference_camera_needs_pybullet(monkeypatch: pytest.MonkeyPatch) -> None:
    assert problem_of_camera("raster") == ""
    assert problem_of_camera("eye") == f"expected one of {', '.join(CAMERAS)}"
    assert (problem_of_camera("tiny") == "") is has_pybullet()
    monkeypatch.setitem(sys.modules, "pybullet", None)
    assert problem_of_camera("raster") == ""
    assert "pip install 'arramon-server[pybullet]'" in problem_of_camera("tiny")
