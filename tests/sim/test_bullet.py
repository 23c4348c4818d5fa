"""pybullet's world: obstacles, and correct, repeatable pictures."""

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from arramon_client.world import AGENT_RADIUS, EYE_HEIGHT, FIELD_OF_VIEW
from arramon_server.sim.assets.meshes import box, moved, quad
from arramon_server.sim.cameras import Actor, Frame, Viewpoint
from arramon_server.sim.catalogue import ObjectType
from arramon_server.sim.scene import Body, BoxCollider, Scene
from tests.physics import Obstacles, ReferenceCamera

BALL = ObjectType("dotted", "red", "ball")
MUG = ObjectType("striped", "blue", "mug")
GREY = np.full((4, 4, 3), 120, np.uint8)
QUARTERS = np.zeros((8, 8, 3), np.uint8)  # red top left, green top right, blue bottom left, white bottom right
QUARTERS[:4, :4, 0] = QUARTERS[:4, 4:, 1] = QUARTERS[4:, :4, 2] = 255
QUARTERS[4:, 4:] = 255

WALL = Body("wall", "wall", "quarters", (0.0, 8.0, 0.0), collider=BoxCollider(2.0, 0.5, 2.0), label="wall")
POST = Body("post", "post", "grey", (5.0, 0.0, 0.0), heading=30.0, collider=BoxCollider(1.0, 0.1, 0.2))
CLOTH = Body("cloth", "post", "grey", (-5.0, 0.0, 0.0))
GROUND = Body("ground", "ground", "grey", (0.0, 0.0, 0.0))
MESHES = {
    "wall": moved(quad([(-2, 0, 0), (2, 0, 0), (2, 0, 2), (-2, 0, 2)]), (0, -0.5, 0)),
    "post": box(2.0, 0.2, 0.2),
    "ground": quad([(-90, -90, 0), (90, -90, 0), (90, 90, 0), (-90, 90, 0)]),
}
SCENE = Scene("test", (WALL, POST, CLOTH, GROUND), MESHES, {"grey": GREY, "quarters": QUARTERS})


@pytest.fixture(scope="module")
def world() -> Iterator[ReferenceCamera]:
    with ReferenceCamera(SCENE) as built:
        yield built


@pytest.fixture(scope="module")
def obstacles() -> Iterator[Obstacles]:
    with Obstacles(SCENE) as built:
        yield built


@pytest.mark.parametrize(
    ("start", "end", "free"),
    [
        ((0.0, 0.0), (0.0, 1.0), True),
        ((0.0, 6.2), (0.0, 7.2), True),  # ends 0.3 from the wall
        ((0.0, 6.3), (0.0, 7.3), False),  # ends 0.2 from it
        ((0.0, 7.0), (0.0, 9.5), False),  # through it
        ((0.0, 8.0), (0.0, 8.0), False),  # stands in it
        ((-3.0, 7.2), (3.0, 7.2), True),  # along it
        ((-3.0, 7.3), (3.0, 7.3), False),
        ((2.26, 8.0), (2.26, 8.0), True),
        ((2.24, 8.0), (2.24, 8.0), False),
        ((-5.0, -1.0), (-5.0, 1.0), True),  # the cloth does not stop anybody
        ((5.0, -1.0), (5.0, 1.0), False),  # low, but in the way
        ((50.0, 50.0), (51.0, 50.0), True),
    ],
)
def test_way_is_free_detects_obstacles_in_both_directions(
    world: ReferenceCamera, obstacles: Obstacles, start: tuple[float, float], end: tuple[float, float], free: bool
) -> None:
    for built in (world, obstacles):
        assert built.way_is_free(start, end) is free
        assert built.way_is_free(end, start) is free


@settings(max_examples=200, deadline=None)
@given(
    x=st.floats(3.0, 7.0),
    y=st.floats(-2.0, 2.0),
    heading=st.floats(0.0, 360.0),
)
def test_way_is_free_agrees_with_plane_geometry(world: ReferenceCamera, x: float, y: float, heading: float) -> None:
    end = (x + math.sin(math.radians(heading)), y + math.cos(math.radians(heading)))
    points = np.linspace((x, y), end, 401)
    turn = math.radians(30.0)
    right = (points[:, 0] - 5) * math.cos(turn) - points[:, 1] * math.sin(turn)
    ahead = (points[:, 0] - 5) * math.sin(turn) + points[:, 1] * math.cos(turn)
    gap = np.hypot(np.maximum(np.abs(right) - 1.0, 0), np.maximum(np.abs(ahead) - 0.1, 0)).min() - AGENT_RADIUS
    if abs(gap) > 2e-3:
        assert world.way_is_free((x, y), end) is bool(gap > 0)


@pytest.mark.parametrize("size", [64, 128, 224])
def test_wall_depth_is_correct_at_every_image_size(world: ReferenceCamera, size: int) -> None:
    frame = world.render(Viewpoint(0, 0, 0), [], size)
    middle = frame.depth[size // 2 - 4 : size // 2 + 1, size // 2 - 4 : size // 2 + 4]
    np.testing.assert_allclose(middle, 7500, rtol=0.005)
    assert frame.rgb.shape == (size, size, 3)
    assert frame.rgb.dtype == np.uint8
    assert frame.depth.dtype == np.uint16


def test_ground_depth_is_correct_in_every_row(world: ReferenceCamera) -> None:
    """The depth of flat ground is the eye's height over the tangent of a row's depression, at the row's middle."""
    depth = world.render(Viewpoint(0, -30, 180), [], 224).depth[:, 112] / 1000.0
    rows = np.arange(130, 224)
    slope = ((rows + 0.5) / 224 * 2 - 1) * math.tan(math.radians(FIELD_OF_VIEW / 2))
    np.testing.assert_allclose(depth[rows], EYE_HEIGHT / slope, rtol=0.002)


def test_far_depth_is_clipped_and_empty_depth_is_zero(world: ReferenceCamera) -> None:
    frame = world.render(Viewpoint(0, -30, 180), [], 224)
    assert (frame.depth[:110] == 0).all()
    assert frame.depth.max() <= 65535
    wall = world.render(Viewpoint(0, -82, 0), [], 224)  # 89.5 from the wall: seen, but beyond what depth can say
    assert wall.depth[111, 112] == 65535
    assert wall.rgb[111, 112].tolist() != frame.rgb[111, 112].tolist()


def test_the_sky_is_blue_above_and_pale_below(world: ReferenceCamera) -> None:
    rgb = world.render(Viewpoint(0, -30, 180), [], 224).rgb.astype(int)
    assert (rgb[0, :, 2] - rgb[0, :, 0] > 60).all()
    assert (np.diff(rgb[:110, 112, 0]) >= 0).all()
    assert np.abs(rgb[109, 112] - 220).max() < 25


def test_textures_are_drawn_upright(world: ReferenceCamera) -> None:
    rgb = world.render(Viewpoint(0, 2, 0), [], 224).rgb.astype(int)
    # The wall is 5.5 away, 4 wide and 2 high: from column 41 to 183, from row 60 down to 130.
    quarters = [rgb[75, 60], rgb[75, 160], rgb[118, 60], rgb[118, 160]]
    assert [tuple(q > 80) for q in quarters] == [
        (True, False, False),
        (False, True, False),
        (False, False, True),
        (True, True, True),
    ]


@pytest.mark.parametrize(
    ("heading", "place", "right"),
    [
        (0.0, (1.0, 3.0, 0.0), True),
        (0.0, (-1.0, 3.0, 0.0), False),
        (90.0, (3.0, -1.0, 0.0), True),
        (90.0, (3.0, 1.0, 0.0), False),
        (180.0, (-1.0, -3.0, 0.0), True),
        (270.0, (-3.0, 1.0, 0.0), True),
    ],
)
def test_objects_to_the_right_are_drawn_on_the_right(
    world: ReferenceCamera, heading: float, place: tuple[float, float, float], right: bool
) -> None:
    view = Viewpoint(0, 0, heading)
    changed = pixels(world.render(view, [Actor(BALL, place)], 224), world.render(view, [], 224))
    columns = np.flatnonzero(changed.any(axis=0))
    assert (columns > 112).all() if right else (columns < 112).all()
    assert len(columns) > 10


def pixels(frame: Frame, other: Frame) -> np.ndarray:
    different: np.ndarray = frame.depth != other.depth
    return different


@pytest.mark.parametrize(
    ("x", "z", "column", "row"), [(0.0, 0.395, 112, 112), (1.0, 0.0, 176.6, 137.3), (-1.0, 1.0, 47.3, 73.0)]
)
def test_actors_are_drawn_at_their_projected_position(
    world: ReferenceCamera, x: float, z: float, column: float, row: float
) -> None:
    """A ball's middle, 0.13 above its base, three units ahead: 194 px a unit at one unit's distance."""
    view = Viewpoint(0, 0, 0)
    changed = pixels(world.render(view, [Actor(BALL, (x, 3.0, z))], 224), world.render(view, [], 224))
    rows, columns = np.nonzero(changed)
    assert (columns.min() + columns.max() + 1) / 2 == pytest.approx(column, abs=1.0)
    assert (rows.min() + rows.max() + 1) / 2 == pytest.approx(row, abs=1.0)


def test_an_actor_faces_its_heading(world: ReferenceCamera) -> None:
    """A mug's handle is on its right, +X of its own: seen from its back at heading 0, from its front at 180."""
    view, bare = Viewpoint(0, 0, 0), world.render(Viewpoint(0, 0, 0), [], 224)
    for heading, longer in ((0.0, "right"), (180.0, "left")):
        changed = pixels(world.render(view, [Actor(MUG, (0.0, 1.5, 0.3), heading)], 224), bare)
        filled = changed.sum(axis=0)[np.flatnonzero(changed.any(axis=0))]
        half = len(filled) // 2
        assert ("right" if filled[-half:].sum() < filled[:half].sum() else "left") == longer


def test_scale_makes_an_actor_larger(world: ReferenceCamera) -> None:
    view, bare = Viewpoint(0, 0, 0), world.render(Viewpoint(0, 0, 0), [], 224)
    small, large = (
        pixels(world.render(view, [Actor(BALL, (0.0, 3.0, 0.0), scale=scale)], 224), bare).any(axis=0).sum()
        for scale in (1.0, 2.0)
    )
    assert large / small == pytest.approx(2.0, rel=0.15)


def test_frames_are_independent_of_earlier_frames(world: ReferenceCamera) -> None:
    view = Viewpoint(1.0, 2.0, 20.0)
    actors = [Actor(BALL, (1.5, 5.0, 0.0)), Actor(BALL, (2.5, 5.0, 0.0), 40.0), Actor(MUG, (2.0, 6.0, 0.2), 70.0, 2.0)]
    first = world.render(view, actors, 128)
    bare = world.render(view, [], 128)
    world.render(Viewpoint(3, 3, 200), [Actor(MUG, (3, 1, 0)), *actors, *actors], 64)
    again = world.render(view, actors, 128)
    assert (again.rgb == first.rgb).all()
    assert (again.depth == first.depth).all()
    assert (world.render(view, [], 128).rgb == bare.rgb).all()
    with ReferenceCamera(SCENE) as other:
        fresh = other.render(view, actors, 128)
    assert (fresh.rgb == first.rgb).all()
    assert (fresh.depth == first.depth).all()


def test_actors_do_not_block_the_way(world: ReferenceCamera) -> None:
    world.render(Viewpoint(0, 0, 0), [Actor(BALL, (0.0, 2.0, 0.0))], 64)
    assert world.way_is_free((0.0, 1.5), (0.0, 2.5))


def test_culling_bodies_outside_the_view_changes_no_pixel(world: ReferenceCamera) -> None:
    """Bodies outside the picture are left out; those that reach into it are not."""
    for heading in range(0, 360, 7):
        view = Viewpoint(4.0, 1.0, float(heading))
        frame = world.render(view, [], 64)
        with_all = ReferenceCamera(replace(SCENE, bodies=SCENE.bodies))
        with_all._cull = lambda viewpoint, removed: None  # type: ignore[method-assign]
        assert (with_all.render(view, [], 64).rgb == frame.rgb).all()
        with_all.close()


@pytest.mark.parametrize(
    ("bodies", "words"),
    [
        ((WALL, replace(POST, name="wall")), "two bodies named 'wall'"),
        ((replace(WALL, mesh="tent"),), "'wall' of scene 'test' names an unknown mesh 'tent'"),
        ((replace(WALL, texture="tartan"),), "names an unknown texture 'tartan'"),
    ],
)
def test_invalid_scenes_are_refused(bodies: tuple[Body, ...], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        ReferenceCamera(replace(SCENE, bodies=bodies))


def test_worlds_are_independent_of_each_other() -> None:
    with ReferenceCamera(SCENE) as one, ReferenceCamera(replace(SCENE, bodies=(GROUND,))) as two:
        assert not one.way_is_free((0, 7), (0, 8))
        assert two.way_is_free((0, 7), (0, 8))
        two.close()
        two.close()
        assert not one.way_is_free((0, 7), (0, 8))


def test_segmentation_labels_visible_objects_on_request(world: ReferenceCamera) -> None:
    view, ball = Viewpoint(0, 0, 0), Actor(BALL, (0.0, 3.0, 0.395))
    assert world.render(view, [ball], 64).segmentation is None
    frame = world.render(view, [ball], 64, segmentation=True)
    assert frame.segmentation is not None
    assert frame.segmentation.dtype == np.uint16
    seen = [world.labels[frame.segmentation[row, 32]] for row in (0, 24, 32, 60)]
    assert seen == ["nothing", "wall", "dotted red ball", "ground"]
    assert ((frame.segmentation == 0) == (frame.depth == 0)).all()


def test_labels_list_the_scene_then_every_collectible(world: ReferenceCamera) -> None:
    assert world.labels[:5] == ("nothing", "cloth", "ground", "post", "wall")
    assert len(world.labels) == 5 + 98
    assert len(set(world.labels)) == len(world.labels)
