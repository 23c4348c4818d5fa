"""Scenes of one section with different furniture: what differs, and what is shared."""

from dataclasses import replace

import numpy as np
import pytest

from arramon_server.sim.cameras import Viewpoint, labels_of
from arramon_server.sim.city import city_scene, refurnished
from arramon_server.sim.raster.camera import RasterCamera
from arramon_server.sim.scene import SceneDifference
from arramon_server.sim.section import Building, Prop, Section

CONES = (Prop("cone", 0.0, 3.0, 0.0, "orange"), Prop("cone", 1.0, 4.0, 0.0, "blue"))
BARREL = Prop("barrel", -1.0, 4.0, 0.0, "gold")
SECTION = Section("1", 0.0, (-9.0, -9.0, 9.0, 9.0), (Building(0.0, 8.0, 4.0, 1.0, 0.0, 3.0, "brick"),), CONES)
HERE = Viewpoint(0.0, 0.0, 0.0)


def test_difference_names_what_is_removed_and_what_is_added() -> None:
    scene = city_scene(SECTION)
    other = refurnished(scene, replace(SECTION, props=(CONES[0], BARREL)))
    difference = SceneDifference.between(scene, other)
    assert [body.name for body in difference.removed] == ["cone/1"]
    assert [body.name for body in difference.added] == ["barrel/0"]
    none = SceneDifference.between(scene, refurnished(scene, SECTION))
    assert (none.removed, none.added) == (frozenset(), ())


def test_props_that_stand_elsewhere_are_other_bodies() -> None:
    scene = city_scene(SECTION)
    other = refurnished(scene, replace(SECTION, props=(CONES[0], replace(CONES[1], x=2.0))))
    difference = SceneDifference.between(scene, other)
    assert [body.position for body in difference.removed] == [(1.0, 4.0, 0.0)]
    assert [body.position for body in difference.added] == [(2.0, 4.0, 0.0)]


def test_spare_props_are_known_but_not_drawn() -> None:
    plain, spare = city_scene(SECTION), city_scene(SECTION, [BARREL])
    assert [body.name for body in spare.bodies] == [body.name for body in plain.bodies]
    assert set(labels_of(spare)) - set(labels_of(plain)) == {"barrel/gold"}
    assert np.array_equal(RasterCamera(spare).render(HERE, [], 64).rgb, RasterCamera(plain).render(HERE, [], 64).rgb)


def test_a_camera_draws_another_scene_with_its_meshes() -> None:
    scene = city_scene(SECTION, [BARREL])
    changed = replace(SECTION, props=(BARREL,))
    drawn = RasterCamera(scene).showing(refurnished(scene, changed)).render(HERE, [], 64)
    expected = RasterCamera(city_scene(changed)).render(HERE, [], 64)
    assert np.array_equal(drawn.rgb, expected.rgb)


def test_what_is_not_spare_cannot_be_drawn() -> None:
    scene = city_scene(SECTION)
    camera = RasterCamera(scene)
    with pytest.raises(KeyError, match="barrel/gold"):
        camera.showing(refurnished(scene, replace(SECTION, props=(BARREL,))))
