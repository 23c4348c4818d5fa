"""City scenes of sections: bodies, proportions of buildings, and ground."""

from contextlib import closing

import numpy as np
import pytest

from arramon_client.world import FACADES, FURNITURE
from arramon_server.sim.assets.facades import BAYS, STOREYS
from arramon_server.sim.cameras import Viewpoint
from arramon_server.sim.city import building_mesh, city_scene
from arramon_server.sim.labels import LABELS
from arramon_server.sim.physics import physics_of
from arramon_server.sim.raster.camera import RasterCamera
from arramon_server.sim.section import Building, Prop, Section

BLOCKS = tuple(
    Building(x, z, 5.0, 4.0, 28.8, height, facade)
    for (x, z), height, facade in zip([(-8, 0), (8, 0), (-8, 12), (8, 12)], (2.6, 4.0, 7.3, 9.0), FACADES, strict=False)
)
PROPS = (Prop("cone", 0, 5, 0, "blue"), Prop("cone", 0, 6, 0), Prop("banner", -3, 3, 90, "red", "star", "white"))
SECTION = Section("toy", 28.8, (-15.0, -5.0, 15.0, 18.0), BLOCKS, PROPS)


def test_bodies_have_their_names_labels_and_colliders() -> None:
    scene = city_scene(SECTION)
    names = [body.name for body in scene.bodies]
    assert names[:3] == ["cone/0", "cone/1", "banner/0"]
    assert names[3:] == [*(f"building/{i}" for i in range(4)), "roofs", "pavements", "kerbs", "lines", "asphalt"]
    solid = {body.name for body in scene.bodies if body.collider}
    assert solid == {"cone/0", "cone/1", *(f"building/{i}" for i in range(4))}
    assert {body.label.partition("/")[0] for body in scene.bodies} == {
        "cone",
        "banner",
        "building",
        "roof",
        "pavement",
        "road",
    }
    assert {body.label for body in scene.bodies} <= {str(label) for label in LABELS}
    assert scene.bodies[0].position == (0, 5, 0.0)


def test_every_prop_and_facade_has_a_mesh_and_a_texture() -> None:
    looks = {"banner": ("green", "dot", "white"), "shop_sign": ("", "hotel")}
    props = tuple(Prop(kind, 3.0 * i, 0, 0, *looks.get(kind, ())) for i, kind in enumerate(FURNITURE))
    buildings = tuple(Building(12.0 * i, 20, 5, 5, 0, 3, facade) for i, facade in enumerate(FACADES))
    scene = city_scene(Section("all", 0.0, (0, 0, 100, 30), buildings, props))
    assert {body.texture for body in scene.bodies} == set(scene.textures)
    assert {body.mesh for body in scene.bodies} == set(scene.meshes)


@pytest.mark.parametrize(("height", "storeys"), [(2.6, 3), (4.0, 4), (7.3, 7), (9.0, 9), (0.4, 1)])
def test_storeys_are_about_a_unit_high_and_doors_at_the_bottom_only(height: float, storeys: int) -> None:
    mesh = building_mesh(Building(0, 0, 5.0, 4.0, 0, height, "brick"))
    assert mesh.vertices[:, 2].max() == pytest.approx(height)
    quads = mesh.triangles[::2]
    low, high = mesh.vertices[quads[:, 0]], mesh.vertices[quads[:, 2]]
    v_low, v_high = mesh.uvs[quads[:, 0], 1], mesh.uvs[quads[:, 2], 1]
    assert ((v_high - v_low) * STOREYS / (high[:, 2] - low[:, 2])) == pytest.approx(storeys / height, rel=1e-5)
    assert ((v_low < 0.2) == (low[:, 2] == 0.0)).all()
    across = np.hypot(*(high - low)[:, :2].T)
    bays = (mesh.uvs[quads[:, 2], 0] - mesh.uvs[quads[:, 0], 0]) * BAYS
    assert sorted(set((across / bays).round(3))) == [1.0]


def test_roofs_have_their_buildings_position_and_heading() -> None:
    scene = city_scene(SECTION)
    first = scene.meshes["roofs"].vertices[:4]
    np.testing.assert_allclose(first.mean(axis=0), (-8.0, 0.0, 2.6), atol=1e-5)
    # The building's own z axis points 28.8 degrees clockwise from +z.
    turn = np.radians(28.8)
    ahead = (first[2] + first[3] - first[0] - first[1]) / 2
    np.testing.assert_allclose(ahead, (8 * np.sin(turn), 8 * np.cos(turn), 0.0), atol=1e-4)


def test_buildings_block_the_agent_where_they_are_seen() -> None:
    scene = city_scene(SECTION)
    with closing(physics_of(scene)) as physics:
        assert physics.way_is_free((0, 3.4), (0, 4.4))
        assert not physics.way_is_free((0, 4), (0, 5))  # the cone
        frame = RasterCamera(scene).render(Viewpoint(-1.0, 0.5, 270), [], 64)
        wall = frame.depth[30, 32] / 1000.0
        # Up to the agent's radius from the wall, by sight; no farther.
        assert physics.way_is_free((-1.0, 0.5), (-1.0 - (wall - 0.35), 0.5))
        assert not physics.way_is_free((-1.0, 0.5), (-1.0 - (wall - 0.15), 0.5))


def test_ground_is_visible_below_the_horizon_in_every_heading() -> None:
    camera = RasterCamera(city_scene(SECTION))
    for heading in range(0, 360, 30):
        frame = camera.render(Viewpoint(0.0, 2.0, heading), [], 64)
        assert (frame.depth[36:] > 0).all(), heading


@pytest.mark.parametrize(("x", "y"), [(0.0, 0.0), (16.0, 3.0), (5.0, -16.0)])
def test_section_without_buildings_has_only_ground(x: float, y: float) -> None:
    """Its ground is laid in squares of 16 units: their corners may lie beside the eye."""
    scene = city_scene(Section("bare", 0.0, (-10, -10, 10, 10), (), ()))
    assert [body.name for body in scene.bodies] == ["asphalt"]
    camera = RasterCamera(scene)
    for heading in (0.0, 90.0, 180.0, 270.0):
        frame = camera.render(Viewpoint(x, y, heading), [], 64)
        assert (frame.depth[36:] > 0).all(), heading


@pytest.mark.parametrize(("prop", "words"), [
    (Prop("fountain", 0, 0, 0), "'fountain'"), (Prop("barrel", 0, 0, 0, "pink"), "'pink'"),
    (Prop("banner", 0, 0, 0, "red", "moon", "blue"), "'moon'"),
])  # fmt: skip
def test_unknown_props_are_refused(prop: Prop, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        city_scene(Section("bad", 0.0, (0, 0, 10, 10), (), (prop,)))
