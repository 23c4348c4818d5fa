"""Joining of triangles to convex polygons, without loss of area or corner attributes."""

import numpy as np
import pytest

from arramon_client.world import COLLECTIBLES, FURNITURE
from arramon_server.sim.assets.collectibles import mesh_of
from arramon_server.sim.assets.furniture import piece_of
from arramon_server.sim.assets.meshes import box, lathe, merge, moved, painted, plate, quad
from arramon_server.sim.raster.polygons import polygons
from arramon_server.sim.scene import Mesh

SQUARE = quad([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)])
HEXAGON = [(2, 0), (1, 2), (-1, 2), (-2, 0), (-1, -2), (1, -2)]
NEXT_TO_IT = moved(SQUARE, (1, 0, 0))
CONTINUED = quad([(1, 0, 0), (2, 0, 0), (2, 1, 0), (1, 1, 0)], (1, 2), (0, 1))
BENT = quad([(1, 0, 0), (1, 0, 1), (1, 1, 1), (1, 1, 0)])
MESHES = {kind: mesh_of(kind) for kind in COLLECTIBLES} | {kind: piece_of(kind).mesh for kind in FURNITURE}


@pytest.mark.parametrize(
    ("mesh", "sides"),
    [
        (SQUARE, [4]),
        (merge(SQUARE, CONTINUED), [6]),  # with the two corners in the middle of its sides
        (merge(SQUARE, NEXT_TO_IT), [4, 4]),  # the texture begins anew
        (painted(merge(SQUARE, NEXT_TO_IT), (0.5, 0.5)), [6]),
        (merge(SQUARE, BENT), [4, 4]),
        (painted(merge(SQUARE, NEXT_TO_IT, moved(SQUARE, (1, 1, 0))), (0, 0)), [6, 3, 3]),  # no L, which is not convex
        (plate(HEXAGON, 0.1)[0], [6]),
        (box(1, 1, 1), [4] * 5),
        (
            painted(lathe([(1.0, 0.0), (0.0, 0.0)], 8), (0, 0)),
            [6, 6],
        ),  # a disc: its halves do not close around the middle
    ],
)
def test_coplanar_triangles_with_one_texture_mapping_are_joined(mesh: Mesh, sides: list[int]) -> None:
    assert sorted(len(polygon.corners) for polygon in polygons(mesh)) == sorted(sides)


@pytest.mark.parametrize("name", MESHES)
def test_polygons_are_convex_and_preserve_the_area(name: str) -> None:
    mesh = MESHES[name]
    points = mesh.vertices.astype(np.float64)
    a, b, c = (points[mesh.triangles[:, i]] for i in range(3))
    whole = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
    area = 0.0
    for polygon in polygons(mesh):
        places, normal = points[list(polygon.corners)], polygon.plane[:3]
        assert np.abs(places @ normal - polygon.plane[3]).max() < 2e-5
        for i in range(len(places)):  # every other corner is to the left of every side
            side = places[(i + 1) % len(places)] - places[i]
            assert (np.cross(side, places - places[i]) @ normal > -1e-6).all()
        area += float(np.cross(places - places[0], np.roll(places, -1, axis=0) - places[0]).sum(axis=0) @ normal) / 2
    assert area == pytest.approx(whole, rel=1e-5)


@pytest.mark.parametrize("name", MESHES)
def test_plane_functions_reproduce_corner_attributes(name: str) -> None:
    mesh = MESHES[name]
    for polygon in polygons(mesh):
        for corner in polygon.corners:
            here = np.array([*mesh.vertices[corner], 1.0])
            u, v = polygon.plane[4:8] @ here, polygon.plane[8:12] @ here
            assert u > -1e-4
            assert v > -1e-4
            same_place = np.flatnonzero((mesh.vertices == mesh.vertices[corner]).all(axis=1))
            apart = np.abs((mesh.uvs[same_place] * [1, -1] - [u, v] + 0.5) % 1.0 - 0.5).max(axis=1)
            normals = polygon.plane[13:].reshape(3, 4) @ here
            apart = np.maximum(apart, np.abs(mesh.normals[same_place] - normals).max(axis=1) - 0.03)
            assert apart.min() < 1e-3


def test_flat_and_smooth_polygons_are_distinguished() -> None:
    assert {polygon.smooth for polygon in polygons(box(1, 1, 1))} == {False}
    assert {polygon.smooth for polygon in polygons(lathe([(1.0, 0.0), (1.0, 1.0)], 8))} == {True}
    assert {polygon.plane[12] for polygon in polygons(painted(box(1, 1, 1), (0.2, 0.7)))} == {0.0}
    assert polygons(box(1, 1, 1, per_texture=0.5))[0].plane[12] == pytest.approx(4.0)


def test_triangles_without_area_are_dropped() -> None:
    thin = Mesh(SQUARE.vertices, SQUARE.uvs, SQUARE.normals, np.array([(0, 1, 1), (0, 1, 2)], np.int32))
    assert [len(polygon.corners) for polygon in polygons(thin)] == [3]
