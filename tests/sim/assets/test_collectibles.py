"""The 98 collectibles: their size, and distinct looks in a frame at three units."""

from collections.abc import Iterator
from itertools import combinations

import numpy as np
import numpy.typing as npt
import pytest

from arramon_client.world import COLLECTIBLE_COLOURS, COLLECTIBLE_PATTERNS, COLLECTIBLES
from arramon_server.sim.assets.collectibles import height_of, mesh_of, texture_of
from arramon_server.sim.assets.meshes import quad
from arramon_server.sim.cameras import Actor, Viewpoint
from arramon_server.sim.catalogue import ALL_TYPES, EXTENT, ObjectType
from arramon_server.sim.scene import Body, Scene
from tests.physics import ReferenceCamera

APART = 10.0
"""Mean absolute difference (of 255, over the pixels and channels of both objects' common bounding box) that tells two
types apart. The closest pair measures 14; a brown bucket is 15 from a red one."""


@pytest.mark.parametrize("kind", COLLECTIBLES)
def test_collectibles_stay_within_their_size(kind: str) -> None:
    mesh = mesh_of(kind)
    assert np.hypot(mesh.vertices[:, 0], mesh.vertices[:, 1]).max() <= EXTENT + 1e-6
    assert mesh.vertices[:, 2].min() == pytest.approx(0.0, abs=1e-6)
    assert 0.1 <= height_of(kind) <= 0.3
    assert len(mesh.triangles) < 500


def test_unknown_kind_is_refused() -> None:
    with pytest.raises(ValueError, match="'teapot' is not one of ball, hourglass"):
        mesh_of("teapot")


def test_textures_hold_mostly_their_own_colour() -> None:
    for kind in ALL_TYPES:
        pattern = texture_of(kind)[16:]
        colours, counts = np.unique(pattern.reshape(-1, 3), axis=0, return_counts=True)
        assert len(colours) == 2
        assert 0.25 < counts.min() / counts.sum() < 0.45, kind
        ground, ink = colours[counts.argmax()].astype(int), colours[counts.argmin()].astype(int)
        assert np.abs(ground - ink).mean() > 80, kind


def test_dots_are_round_and_stripes_run_around() -> None:
    dotted, striped = (texture_of(ObjectType(p, "red", "ball"))[16:, :, 1] > 128 for p in COLLECTIBLE_PATTERNS)
    assert (striped == striped[:, :1]).all()
    row = dotted[-16:, : 128 // 6]
    assert abs(row.any(axis=0).sum() - row.any(axis=1).sum()) <= 1


@pytest.fixture(scope="module")
def world() -> Iterator[ReferenceCamera]:
    ground = quad([(-50, -50, 0), (50, -50, 0), (50, 50, 0), (-50, 50, 0)])
    grey = np.full((4, 4, 3), 120, np.uint8)
    scene = Scene("plain", (Body("ground", "ground", "grey", (0, 0, 0)),), {"ground": ground}, {"grey": grey})
    with ReferenceCamera(scene) as built:
        yield built


def seen(
    world: ReferenceCamera, kind: ObjectType, heading: float
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.bool_]]:
    """The middle of the frame with the object three units ahead, and which of its pixels are the object."""
    frame = world.render(Viewpoint(0, 0, 0), [Actor(kind, (0.0, 3.0, 0.0), heading)], 224)
    bare = world.render(Viewpoint(0, 0, 0), [], 224)
    cut = (slice(112, 168), slice(90, 134))
    return frame.rgb[cut].astype(np.int64), frame.depth[cut] != bare.depth[cut]


@pytest.mark.parametrize("heading", [180.0, 215.0, 20.0])
def test_all_98_collectibles_look_different_at_three_units(world: ReferenceCamera, heading: float) -> None:
    views = {kind: seen(world, kind, heading) for kind in ALL_TYPES}
    for kind, (_, mask) in views.items():
        height, width = (np.ptp(np.flatnonzero(mask.any(axis=axis))) + 1 for axis in (1, 0))
        assert height >= 7, kind
        assert width >= 9, kind
        assert max(height, width) <= 22, kind
    closest = min((difference(views[a], views[b]), str(a), str(b)) for a, b in combinations(ALL_TYPES, 2))
    assert len(views) == len(COLLECTIBLE_PATTERNS) * len(COLLECTIBLE_COLOURS) * len(COLLECTIBLES) == 98
    assert closest[0] > APART, closest


def difference(
    a: tuple[npt.NDArray[np.int64], npt.NDArray[np.bool_]], b: tuple[npt.NDArray[np.int64], npt.NDArray[np.bool_]]
) -> float:
    """Mean absolute difference over the bounding box of both objects."""
    either = a[1] | b[1]
    rows, columns = np.flatnonzero(either.any(axis=1)), np.flatnonzero(either.any(axis=0))
    cut = (slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1))
    return float(np.abs(a[0][cut] - b[0][cut]).mean())
