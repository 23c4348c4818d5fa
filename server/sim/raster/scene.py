"""Conversion of a scene to the rasteriser's arrays: convex polygons and textures with mipmaps.

A polygon is described by its plane and by affine functions of the position on it (texture coordinates, normal), so that
nothing must be computed from its corners when it is drawn, however it is clipped.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from arramon_server.sim.raster.arrays import Floats, Geometry, Integers, Textures
from arramon_server.sim.raster.polygons import Polygon, polygons
from arramon_server.sim.scene import Mesh

LEVELS = 10
"""Maximum number of mipmap levels of a texture."""

CLUSTER = 24
"""Maximum number of polygons in a cluster of a large mesh; clusters are culled as a whole."""

_COMPACT = 6.0
"""A mesh within this radius, in units, is one cluster."""


@dataclass(frozen=True, eq=False)
class _Flat:
    """The arrays of one mesh, as in `Geometry`."""

    points: Floats
    corners: Integers
    shapes: Integers
    planes: Floats
    clusters: Integers
    spheres: Floats


def geometry(meshes: Sequence[Mesh]) -> Geometry:
    """Convert meshes to arrays; meshes keep their indices."""
    flats = [_flat(mesh) for mesh in meshes]
    points, first_corner, first_polygon, first_cluster = 0, 0, 0, 0
    shapes, clusters, ranges = [], [], []
    for flat in flats:
        shapes.append(flat.shapes + np.array([first_corner, 0, 0], np.int32))
        clusters.append(flat.clusters + np.array([points, first_polygon, points, first_polygon], np.int32))
        ranges.append((first_cluster, first_cluster + len(flat.clusters)))
        points += len(flat.points)
        first_corner += len(flat.corners)
        first_polygon += len(flat.shapes)
        first_cluster += len(flat.clusters)
    return Geometry(
        points=np.concatenate([flat.points for flat in flats]),
        corners=np.concatenate([flat.corners for flat in flats]),
        shapes=np.concatenate(shapes),
        planes=np.concatenate([flat.planes for flat in flats]),
        clusters=np.concatenate(clusters),
        spheres=np.concatenate([flat.spheres for flat in flats]),
        meshes=np.array(ranges, np.int32),
    )


def textures(images: Sequence[npt.NDArray[np.uint8]]) -> Textures:
    """Convert images, (height, width, 3) each, to textures with mipmaps; images keep their indices."""
    sheets: list[Integers] = []
    places, used = [], 0
    for image in images:
        height, width = image.shape[:2]
        rows = 2 * (1 << (max(height, width) - 1).bit_length())
        sheet = np.zeros((rows, width), np.int32)
        chain = _mipmaps(image)
        for i, level in enumerate(chain):
            top = rows - (rows >> i)
            sheet[top : top + level.shape[0], : level.shape[1]] = _packed(level)
        sheets.append(sheet.reshape(-1))
        places.append((used, width, height, rows, len(chain)))
        used += sheet.size
    return Textures(np.concatenate([np.zeros(0, np.int32), *sheets]), np.array(places, np.int32).reshape(-1, 5))


def indices_of(names: Iterable[str]) -> dict[str, int]:
    """Return the index of each name."""
    return {name: number for number, name in enumerate(names)}


def _packed(image: npt.NDArray[np.uint8]) -> Integers:
    """Return an image, (height, width, 3), as (height, width) int32: red in the lowest byte."""
    wide = image.astype(np.int32)
    return wide[..., 0] | wide[..., 1] << 8 | wide[..., 2] << 16


def _mipmaps(image: npt.NDArray[np.uint8]) -> list[npt.NDArray[np.uint8]]:
    """Return the image, then levels of half the size each, down to one pixel; odd edges are repeated."""
    chain = [image]
    exact = image.astype(np.float64)
    while max(exact.shape[:2]) > 1 and len(chain) < LEVELS:
        height, width = exact.shape[:2]
        even = exact
        if height % 2 or width % 2:
            even = np.pad(exact, ((0, height % 2), (0, width % 2), (0, 0)), mode="edge")
        exact = (even[0::2, 0::2] + even[1::2, 0::2] + even[0::2, 1::2] + even[1::2, 1::2]) / 4
        chain.append(np.rint(exact).astype(np.uint8))
    return chain


@lru_cache(maxsize=1024)
def _flat(mesh: Mesh) -> _Flat:
    found = polygons(mesh)
    points, corners, shapes, planes, clusters, spheres = [], [], [], [], [], []
    first_point, first_corner, first_polygon = 0, 0, 0
    for group in _groups(mesh, found):
        own: dict[int, int] = {}
        for polygon in group:
            numbers = [own.setdefault(corner, len(own)) for corner in polygon.corners]
            corners.extend(numbers)
            shapes.append((first_corner, len(numbers), polygon.smooth))
            planes.append(polygon.plane)
            first_corner += len(numbers)
        places = mesh.vertices[list(own)]
        centre = (places.min(axis=0) + places.max(axis=0)) / 2
        radius = np.linalg.norm(places - centre, axis=1).max()
        points.append(places)
        clusters.append((first_point, first_polygon, first_point + len(own), first_polygon + len(group)))
        spheres.append((*centre, radius * 1.0001 + 1e-6))
        first_point += len(own)
        first_polygon += len(group)
    return _Flat(
        np.concatenate(points).astype(np.float32),
        np.array(corners, np.int32),
        np.array(shapes, np.int32),
        np.array(planes, np.float32),
        np.array(clusters, np.int32),
        np.array(spheres, np.float32),
    )


def _groups(mesh: Mesh, found: list[Polygon]) -> list[list[Polygon]]:
    """Group polygons by proximity; their order is kept within a group."""
    middles = np.array([mesh.vertices[list(polygon.corners)].mean(axis=0) for polygon in found])
    groups: list[list[Polygon]] = []
    waiting = [np.arange(len(found))]
    while waiting:
        members = waiting.pop()
        spread = np.ptp(middles[members], axis=0)
        if len(members) <= CLUSTER or np.linalg.norm(spread) / 2 <= _COMPACT:
            groups.append([found[i] for i in np.sort(members)])
            continue
        order = members[np.argsort(middles[members, int(np.argmax(spread))], kind="stable")]
        half = len(order) // 2
        waiting += [order[half:], order[:half]]
    return groups
