"""The fast camera: agreement with the reference camera, and identical bytes in every process."""

import hashlib
import math
import subprocess
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

from arramon_client.world import EYE_HEIGHT, FACADES, FURNITURE
from arramon_server.sim.assets.meshes import box, merge, moved, quad
from arramon_server.sim.cameras import Actor, Camera, Frame, Viewpoint, colourless, label_of, labels_of
from arramon_server.sim.catalogue import ALL_TYPES, ObjectType
from arramon_server.sim.city import city_scene
from arramon_server.sim.raster.camera import RasterCamera, compile_kernels, is_compiled
from arramon_server.sim.room_scene import room_scene
from arramon_server.sim.scene import Body, Scene
from arramon_server.sim.section import Building, Prop, Section
from tests.physics import ReferenceCamera

BALL, MUG = ObjectType("dotted", "red", "ball"), ObjectType("striped", "blue", "mug")

CENTRES = [*((x, z) for z in (0, 14) for x in (-18, -6, 6, 18)), (-18, 28), (-6, 28), (6, 28)]
LOOKS = {"banner": ("green", "dot", "white"), "shop_sign": ("", "hotel")}
BLOCKS = tuple(
    Building(x, z, 4.5, 3.5, 28.8, 2.6 + i, facade)
    for i, (facade, (x, z)) in enumerate(zip(FACADES, CENTRES, strict=True))
)
PROPS = tuple(
    Prop(kind, -8.0 + i, 6.5 + math.sin(i), 40.0 * i, *LOOKS.get(kind, ())) for i, kind in enumerate(FURNITURE)
)
STREET = city_scene(Section("toy", 28.8, (-20.0, -8.0, 20.0, 20.0), BLOCKS, PROPS))
"""Every facade and every kind of furniture on a street."""

STREET_ACTORS = [Actor(type_, (-7.0 + i, 8.5, 0.0), 25.0 * i) for i, type_ in enumerate(ALL_TYPES[::7])]
ROOM_ACTORS = [Actor(type_, (1.5 * (i % 5), 1.5 * (i // 5), 0.0), 0.0, 2.0) for i, type_ in enumerate(ALL_TYPES[::5])]


def viewpoints(low: tuple[float, float], high: tuple[float, float], count: int) -> list[Viewpoint]:
    chance = np.random.default_rng(1)
    places, headings = chance.uniform(low, high, (count, 2)), chance.uniform(0, 360, count)
    return [Viewpoint(x, y, heading) for (x, y), heading in zip(places.tolist(), headings.tolist(), strict=True)]


@pytest.fixture(scope="module")
def camera() -> RasterCamera:
    return RasterCamera(STREET)


@pytest.fixture(scope="module")
def reference() -> Iterator[ReferenceCamera]:
    with ReferenceCamera(STREET) as world:
        yield world


def agreement(one: Frame, other: Frame) -> tuple[float, float, float]:
    """The share of pixels that agree in depth and in segmentation, and the mean absolute difference of the colours."""
    assert one.segmentation is not None
    assert other.segmentation is not None
    a, b = one.depth.astype(int), other.depth.astype(int)
    deep = (np.abs(a - b) <= np.maximum(10, 0.005 * a)) & ((a == 0) == (b == 0))
    same = one.segmentation == other.segmentation
    return float(deep.mean()), float(same.mean()), float(np.abs(one.rgb.astype(int) - other.rgb).mean())


def both(
    reference: Camera, camera: Camera, view: Viewpoint, actors: Sequence[Actor], size: int = 224
) -> tuple[float, float, float]:
    return agreement(
        reference.render(view, actors, size, segmentation=True), camera.render(view, actors, size, segmentation=True)
    )


def test_street_rendering_matches_the_reference(reference: ReferenceCamera) -> None:
    plain = RasterCamera(STREET, mipmaps=False)
    found = [both(reference, plain, view, STREET_ACTORS) for view in viewpoints((-9, 5), (9, 9), 25)]
    assert min(depth for depth, _, _ in found) > 0.997
    assert min(labels for _, labels, _ in found) > 0.997
    assert np.mean([colour for _, _, colour in found]) < 0.3


def test_mipmaps_change_only_colours_and_only_slightly(reference: ReferenceCamera, camera: RasterCamera) -> None:
    plain = RasterCamera(STREET, mipmaps=False)
    for view in viewpoints((-9, 5), (9, 9), 5):
        ours, without = (c.render(view, STREET_ACTORS, 224, segmentation=True) for c in (camera, plain))
        assert agreement(ours, without)[:2] == (1.0, 1.0)
        assert both(reference, camera, view, STREET_ACTORS)[2] < 8.0


def test_room_rendering_matches_the_reference() -> None:
    plain = RasterCamera(room_scene(), mipmaps=False)
    with ReferenceCamera(room_scene()) as world:
        for view in viewpoints((0, 0), (6, 4.5), 15):
            actors = [a for a in ROOM_ACTORS if math.dist(a.position[:2], (view.x, view.y)) > 1.0]
            depth, labels, colour = both(world, plain, view, actors)
            assert depth > 0.997
            assert labels > 0.997
            assert colour < 0.5


@pytest.mark.parametrize("size", [17, 30, 64, 128])
def test_pictures_of_any_size_match_the_reference(reference: ReferenceCamera, camera: RasterCamera, size: int) -> None:
    depth, labels, _ = both(reference, camera, Viewpoint(0, 6, 60), STREET_ACTORS, size)
    assert depth > 0.99
    assert labels > 0.99
    frame = camera.render(Viewpoint(0, 6, 60), [], size)
    assert frame.rgb.shape == (size, size, 3)
    assert frame.rgb.dtype == np.uint8
    assert frame.depth.shape == (size, size)
    assert frame.depth.dtype == np.uint16


@pytest.mark.parametrize("heading", [0.0, 45.0, 90.0, 117.0, 290.0])
def test_views_near_and_inside_walls_match_the_reference(heading: float) -> None:
    """Walls that the near plane cuts: a narrow lane seen from its middle, and from within one of its walls."""
    walls = merge(moved(box(0.4, 30.0, 3.0), (0.4, 0.0, 0.0)), moved(box(0.4, 30.0, 3.0), (-0.4, 0.0, 0.0)))
    floor = quad([(-20, -20, 0), (20, -20, 0), (20, 20, 0), (-20, 20, 0)])
    bodies = (Body("lane", "lane", "stone", (0, 0, 0)), Body("floor", "floor", "stone", (0, 0, 0)))
    stone = np.random.default_rng(2).integers(0, 255, (32, 32, 3)).astype(np.uint8)
    scene = Scene("lane", bodies, {"lane": walls, "floor": floor}, {"stone": stone})
    plain = RasterCamera(scene, mipmaps=False)
    with ReferenceCamera(scene) as world:
        for x in (0.0, 0.13, 0.4):
            depth, labels, _ = both(world, plain, Viewpoint(x, 1.0, heading), [])
            assert depth > 0.99
            assert labels > 0.99


def test_ground_depth_is_correct_in_every_row(camera: RasterCamera) -> None:
    depth = camera.render(Viewpoint(0, -30, 180), [], 224).depth[:, 112] / 1000.0
    rows = np.arange(116, 224)
    slope = ((rows + 0.5) / 224 * 2 - 1) * math.tan(math.radians(30.0))
    np.testing.assert_allclose(depth[rows], EYE_HEIGHT / slope, atol=0.0006)


def test_object_behind_a_wall_is_drawn_where_visible() -> None:
    """A ball behind a wall is left out only when none of it can be seen."""
    stone = np.full((4, 4, 3), 90, np.uint8)
    scene = Scene("wall", (Body("wall", "wall", "stone", (0, 4, 0)),), {"wall": box(4.0, 0.2, 1.0)}, {"stone": stone})
    camera, shown = RasterCamera(scene), []
    with ReferenceCamera(scene) as world:
        for height in np.linspace(0.6, 1.6, 11).tolist():
            ball = Actor(BALL, (0.3, 7.0, height))
            assert both(world, camera, Viewpoint(0, 0, 0), [ball])[1] > 0.9995
            frame = camera.render(Viewpoint(0, 0, 0), [ball], 224, segmentation=True)
            shown.append(np.count_nonzero(frame.segmentation == camera.labels.index(str(BALL))))
    assert shown[0] == 0
    assert 0 < shown[6] < shown[7] < shown[-1]


def test_labels_equal_the_references(reference: ReferenceCamera, camera: RasterCamera) -> None:
    assert camera.labels == reference.labels == labels_of(STREET)
    assert camera.labels[0] == "nothing"
    assert label_of(Body("cone/3", "m", "t", (0, 0, 0))) == "cone"
    assert label_of(Body("cone/3", "m", "t", (0, 0, 0), label="orange cone")) == "orange cone"


def test_segmentation_is_rendered_only_on_request(camera: RasterCamera) -> None:
    assert camera.render(Viewpoint(0, 6, 0), [], 64).segmentation is None
    frame = camera.render(Viewpoint(0, 6, 0), [Actor(MUG, (0.0, 6.8, 0.4))], 64, segmentation=True)
    assert frame.segmentation is not None
    assert frame.segmentation.dtype == np.uint16
    assert camera.labels[frame.segmentation[34, 32]] == "striped blue mug"
    assert ((frame.segmentation == 0) == (frame.depth == 0)).all()


def test_frames_are_not_overwritten_and_independent_of_others(camera: RasterCamera) -> None:
    view = Viewpoint(1.0, 6.0, 200.0)
    first = camera.render(view, STREET_ACTORS, 128, segmentation=True)
    assert first.segmentation is not None
    copies = first.rgb.copy(), first.depth.copy(), first.segmentation.copy()
    crowd = [Actor(BALL, (0.1 * i, 7.0, 0.0)) for i in range(90)]
    camera.render(Viewpoint(-4, 7, 20), crowd, 128)
    again = camera.render(view, STREET_ACTORS, 128, segmentation=True)
    for kept, copy, new in zip((first.rgb, first.depth, first.segmentation), copies, vars(again).values(), strict=True):
        np.testing.assert_array_equal(kept, copy)
        np.testing.assert_array_equal(new, copy)


def test_depth_in_units_is_the_same_times_a_thousandth(reference: ReferenceCamera, camera: RasterCamera) -> None:
    view, far = Viewpoint(0, 6, 60), Viewpoint(0, -30, 180)
    for drawing in (reference, camera):
        for seen, size in ((view, 64), (far, 30)):
            frame = drawing.render(seen, STREET_ACTORS, size, segmentation=True)
            units, labels = np.ones((size, size), np.float32), np.ones((size, size), np.uint16)
            into = Frame(np.ones((size, size, 3), np.uint8), units, labels)
            other = drawing.render(seen, STREET_ACTORS, size, segmentation=True, into=into)
            assert other.depth is units
            assert units.tobytes() == (frame.depth.astype(np.float32) * np.float32(0.001)).tobytes()
            assert (into.rgb == frame.rgb).all()
            assert (labels == frame.segmentation).all()


def test_without_colours_depth_and_labels_are_the_same(reference: ReferenceCamera, camera: RasterCamera) -> None:
    for drawing in (reference, camera):
        for seen, size in ((Viewpoint(0, 6, 60), 64), (Viewpoint(0, -30, 180), 30)):
            frame = drawing.render(seen, STREET_ACTORS, size, segmentation=True)
            plain = drawing.render(seen, STREET_ACTORS, size, segmentation=True, into=colourless(size))
            assert plain.rgb.size == 0
            assert plain.depth.tobytes() == frame.depth.tobytes()
            assert plain.segmentation is not None
            assert frame.segmentation is not None
            assert plain.segmentation.tobytes() == frame.segmentation.tobytes()


def test_threads_draw_at_once_what_one_alone_draws(camera: RasterCamera) -> None:
    views = [Viewpoint(0.5 * number, -0.25 * number, 30.0 * number) for number in range(24)]

    def draw(view: Viewpoint) -> tuple[bytes, bytes, bytes]:
        frame = camera.render(view, [], 224, segmentation=True)
        assert frame.segmentation is not None
        return frame.rgb.tobytes(), frame.depth.tobytes(), frame.segmentation.tobytes()

    alone = list(map(draw, views))
    with ThreadPoolExecutor(4) as threads:
        assert list(threads.map(draw, views)) == alone


def test_scene_order_decides_between_equal_depths() -> None:
    flat = quad([(-2, -2, 0), (2, -2, 0), (2, 2, 0), (-2, 2, 0)])
    covers = {"dark": np.full((2, 2, 3), 20, np.uint8), "light": np.full((2, 2, 3), 200, np.uint8)}
    one, two = (Body(cover, "flat", cover, (0, 2 + i, 0)) for i, cover in enumerate(covers))
    for bodies, seen in (((one, two), "light"), ((two, one), "dark")):
        camera = RasterCamera(Scene("flat", bodies, {"flat": flat}, covers))
        frame = camera.render(Viewpoint(0, 0, 0), [], 64, segmentation=True)
        assert frame.segmentation is not None
        assert camera.labels[frame.segmentation[55, 32]] == seen


def test_mipmaps_reduce_noise_in_distant_textures() -> None:
    """A fine chequerboard 40 units away is noise to nearest sampling, and nearly grey with mipmaps."""
    board = (np.indices((64, 64)).sum(axis=0) % 2 * 255).astype(np.uint8)[..., None].repeat(3, axis=2)
    wall = quad([(-30, 0, 0), (30, 0, 0), (30, 0, 60), (-30, 0, 60)], (0, 60), (0, 60))
    scene = Scene("board", (Body("wall", "wall", "board", (0, 40, -20)),), {"wall": wall}, {"board": board})
    spread = [
        RasterCamera(scene, mipmaps=mipmaps).render(Viewpoint(0, 0, 0), [], 128).rgb[20:100, 20:100].std()
        for mipmaps in (False, True)
    ]
    assert spread[0] > 80
    assert spread[1] < 3


DRAW = """
from tests.sim.raster.test_camera import STREET, digest
from arramon_server.sim.raster.camera import RasterCamera, is_compiled
print(is_compiled(), digest(RasterCamera(STREET)))
"""

NOWHERE_TO_KEEP_IT = """
import numba
compiled = numba.njit
def njit(*arguments, cache=False, **options):
    if cache:
        raise RuntimeError("cannot cache function: no locator available")
    return compiled(*arguments, **options)
numba.njit = njit
"""


def digest(camera: RasterCamera) -> str:
    found = hashlib.sha256()
    for view in viewpoints((-9, 5), (9, 9), 12):
        frame = camera.render(view, STREET_ACTORS, 128, segmentation=True)
        assert frame.segmentation is not None
        for array in (frame.rgb, frame.depth, frame.segmentation):
            found.update(array.tobytes())
    return found.hexdigest()


def run(code: str) -> list[str]:
    command = [sys.executable, "-c", code]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.split()


def test_cached_kernels_draw_identical_images_in_another_process(camera: RasterCamera) -> None:
    compile_kernels()
    assert is_compiled()
    assert run(DRAW) == ["True", digest(camera)]


@pytest.mark.slow
def test_uncached_kernels_draw_identical_images(camera: RasterCamera) -> None:
    """As on a machine where no folder can be written."""
    assert run(NOWHERE_TO_KEEP_IT + DRAW) == ["False", digest(camera)]


def test_rotated_and_scaled_actors_match_the_reference(reference: ReferenceCamera, camera: RasterCamera) -> None:
    actor = Actor(MUG, (0.2, 7.4, 0.1), 70.0, 2.5)
    for view in (Viewpoint(0, 6, 0), replace(Viewpoint(0, 6, 10), z=1.4), Viewpoint(1.2, 8.2, 230)):
        depth, labels, _ = both(reference, camera, view, [actor])
        assert depth > 0.997
        assert labels > 0.997
