"""Textures: sizes, determinism, and distinguishable looks."""

from itertools import combinations

import numpy as np
import pytest

from arramon_client.world import FACADES
from arramon_server.sim.assets.banners import COLOURS, SHAPES, banner_mesh, banner_texture
from arramon_server.sim.assets.facades import BAYS, STOREYS, facade
from arramon_server.sim.assets.palette import COLOURS as PALETTE
from arramon_server.sim.assets.palette import palette, swatch
from arramon_server.sim.assets.textures import bricks, plain, speckled, texture

NAMES = (
    "asphalt",
    "pavement",
    "roof",
    "kerb",
    "wall/wood",
    "wall/brick",
    "wall/spotted",
    "wall/striped",
    "start",
    "floor",
)


@pytest.mark.parametrize("image", [*(texture(n) for n in NAMES), *(facade(f) for f in FACADES), palette()])
def test_textures_are_small_read_only_rgb_images(image: np.ndarray) -> None:
    assert image.dtype == np.uint8
    assert image.ndim == 3
    assert image.shape[2] == 3
    assert max(image.shape[:2]) <= 256
    assert not image.flags.writeable


def test_textures_are_reproducible() -> None:
    for name in NAMES:
        first = texture(name)
        texture.cache_clear()
        assert (texture(name) == first).all()


def test_facades_differ_and_have_their_own_ground_floor() -> None:
    for name in FACADES:
        image = facade(name).astype(int)
        storey = image.shape[0] // STOREYS
        assert image.shape[1] == BAYS * storey
        assert np.abs(image[-storey:] - image[:storey]).mean() > 8, name
    for a, b in combinations(FACADES, 2):
        assert np.abs(facade(a).astype(int) - facade(b).astype(int)).mean() > 20, (a, b)


def test_brick_texture_repeats_without_a_seam() -> None:
    image = bricks(32, 64, (200, 0, 0), (0, 0, 0), seed=1, course=8, length=16, vary=0)
    joints = (image[..., 0] == 0).sum(axis=1)
    assert joints.tolist() == [4, 4, 4, 4, 4, 4, 4, 64] * 4


def test_speckles_stay_within_their_amount() -> None:
    image = speckled(plain(20, 30, (100, 100, 100)), 10, seed=3, grain=4).astype(int)
    assert np.abs(image - 100).max() in range(6, 11)


@pytest.mark.parametrize(("shape", "share"), [
    ("circle", 0.34), ("dot", 0.08), ("diamond", 0.20), ("triangle", 0.17), ("hexagon", 0.31), ("star", 0.16),
])  # fmt: skip
def test_banners_show_their_shape(shape: str, share: float) -> None:
    image = banner_texture("blue", shape, "yellow")
    inner = (image[10:-6, 6:-6] == COLOURS["yellow"]).all(axis=-1)
    assert inner.mean() * inner.size / (88 * 72) == pytest.approx(share, abs=0.05)
    assert (inner == inner[:, ::-1]).mean() > 0.98


def test_banner_shapes_look_different() -> None:
    for a, b in combinations(SHAPES, 2):
        assert (banner_texture("white", a, "red") != banner_texture("white", b, "red")).mean() > 0.02, (a, b)


@pytest.mark.parametrize("words", [("pink", "star", "red"), ("red", "moon", "blue"), ("red", "star", "pink")])
def test_unknown_banner_colours_and_shapes_are_refused(words: tuple[str, str, str]) -> None:
    with pytest.raises(ValueError, match=r"'(pink|moon)' is not one of"):
        banner_texture(*words)


def test_a_banner_hangs_in_front_of_its_wall() -> None:
    mesh = banner_mesh()
    assert mesh.vertices[:, 1].min() > 0.0
    assert mesh.vertices[:, 2].min() > 0.5


def test_swatches_have_their_colours() -> None:
    image = palette()
    for colour, rgb in PALETTE.items():
        u, v = swatch(colour)
        assert tuple(image[int((1 - v) * 128), int(u * 128)]) == rgb
    with pytest.raises(ValueError, match="'teal' is not one of"):
        swatch("teal")
