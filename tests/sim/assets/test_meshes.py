"""Meshes: closed shapes, outward winding, and valid texture coordinates."""

import numpy as np
import pytest

from arramon_client.world import COLLECTIBLES, FURNITURE
from arramon_server.sim.assets.collectibles import mesh_of
from arramon_server.sim.assets.furniture import COLOURS, piece_of
from arramon_server.sim.assets.meshes import (
    arc,
    ball,
    box,
    lathe,
    mapped,
    merge,
    moved,
    painted,
    plate,
    quad,
    stretched,
    tube,
)
from arramon_server.sim.scene import Mesh

SQUARE = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
MESHES = {
    "box": box(1, 2, 3),
    "raised box": box(1, 2, 3, base=0.5),
    "cup": lathe([(0, 0), (1, 0), (1, 2), (0.8, 2), (0.8, 0.5), (0, 0.5)]),
    "ball": ball(1.0, 1.0),
    "ring": tube(arc((0, 0, 2), 1.0, 0, 180), 0.1),
    "plate": merge(*plate(SQUARE, 0.2)),
    "moved": moved(box(1, 2, 3), (1, 2, 3), turn=40, pitch=30),
    "stretched": stretched(ball(1.0, 1.0), 2.0, 1.0, 0.5),
    **{kind: mesh_of(kind) for kind in COLLECTIBLES},
    **{f"{kind} {colour}": piece_of(kind, colour).mesh for kind in FURNITURE for colour in COLOURS.get(kind, ("",))},
}


def faces(mesh: Mesh) -> np.ndarray:
    """Twice each triangle's area times its normal, by its winding."""
    a, b, c = (mesh.vertices[mesh.triangles[:, i]].astype(np.float64) for i in range(3))
    return np.cross(b - a, c - a)


@pytest.mark.parametrize("name", MESHES)
def test_mesh_arrays_have_valid_shapes_types_and_values(name: str) -> None:
    mesh = MESHES[name]
    n = len(mesh.vertices)
    assert [mesh.vertices.shape, mesh.uvs.shape, mesh.normals.shape] == [(n, 3), (n, 2), (n, 3)]
    assert [a.dtype for a in (mesh.vertices, mesh.uvs, mesh.normals)] == [np.float32] * 3
    assert mesh.triangles.dtype == np.int32
    assert mesh.triangles.min() >= 0
    assert mesh.triangles.max() < n
    assert mesh.uvs.min() >= 0
    np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1.0, atol=1e-5)


@pytest.mark.parametrize("name", MESHES)
def test_triangle_winding_matches_the_normals(name: str) -> None:
    mesh = MESHES[name]
    assert (np.einsum("ij,ikj->ik", faces(mesh), mesh.normals[mesh.triangles]) > 0).all()


@pytest.mark.parametrize(
    ("mesh", "volume"),
    [
        (box(1, 2, 3, base=0.5), 6.0),
        (lathe([(0, 0), (1, 0), (1, 2), (0, 2)], sides=4), 4.0),
        (lathe([(0, 0), (1, 0), (1, 2), (0.5, 2), (0.5, 1), (0, 1)], sides=4), 3.5),
        (merge(*plate(SQUARE, 0.2)), 0.8),
        (moved(box(1, 2, 3, base=0.5), (4, 5, 6), turn=77, pitch=20), 6.0),
        (stretched(box(1, 1, 1, base=0.5), 2, 3, 4), 24.0),
    ],
)
def test_closed_shapes_enclose_their_volume(mesh: Mesh, volume: float) -> None:
    first = mesh.vertices[mesh.triangles[:, 0]].astype(np.float64)
    assert np.einsum("ij,ij->", first, faces(mesh)) / 6 == pytest.approx(volume, rel=1e-5)


def test_moved_turns_clockwise_seen_from_above() -> None:
    forward = quad([(0, 1, 0), (0, 1, 0.1), (0, 1, 0.2), (0, 0.9, 0.2)])
    np.testing.assert_allclose(moved(forward, turn=90.0).vertices[0], (1.0, 0.0, 0.0), atol=1e-6)


def test_a_plate_faces_ahead_and_reads_from_left_to_right() -> None:
    front, back, _ = plate(SQUARE, 0.2)
    np.testing.assert_allclose(front.normals, [[0, 1, 0]] * 4)
    np.testing.assert_allclose(back.normals, [[0, -1, 0]] * 4)
    # Whoever looks at the front looks along -Y and has +X to the left.
    assert front.uvs[np.argmax(front.vertices[:, 0]), 0] == 0.0


def test_painted_and_mapped_set_texture_coordinates() -> None:
    assert np.unique(painted(box(1, 1, 1), (0.25, 0.75)).uvs, axis=0).tolist() == [[0.25, 0.75]]
    uvs = mapped(quad([(0, 0, 0), (1, 0, 0), (1, 0, 1), (0, 0, 1)]), (0.5, 1.0), (0.0, 0.25)).uvs
    assert uvs.tolist() == [[0.5, 0.0], [1.0, 0.0], [1.0, 0.25], [0.5, 0.25]]
