"""Merging of a mesh's triangles into convex polygons, each with its plane and affine functions."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from arramon_server.sim.scene import Mesh
from arramon_server.sim.vectors import cross, successors

_FLAT, _SAME_UV, _SAME_NORMAL = 1e-5, 1e-4, 0.03
"""Largest differences between two triangles to be merged: in units, in texture coordinates, and of unit normals."""

_SAME_PLACE = 1e-6
"""Corners nearer to each other than this, in units, count as one in the convexity check."""

_MOST_CORNERS = 12

Vector = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Polygon:
    """A convex planar part of a mesh.

    Attributes:
        corners: indices of the mesh's vertices, counter-clockwise seen from outside; equal positions share an index.
        plane: (25,) as in `arrays.Geometry.planes`.
        smooth: whether the normal varies over it.
    """

    corners: tuple[int, ...]
    plane: Vector
    smooth: bool


@dataclass(eq=False)
class _FlatPart:
    corners: list[int]
    normal: Vector
    distance: float
    functions: Vector  # (5, 4): u, v and the normal, each as factors of (x, y, z, 1)


def polygons(mesh: Mesh) -> list[Polygon]:
    """Merge the mesh's triangles: two that share an edge, lie in one plane and have continuous texture and normals.

    Triangles without an area are left out.
    """
    places = _position_numbers(mesh.vertices)
    points = mesh.vertices.astype(np.float64)
    # With a 1 behind each: the affine functions are products with these.
    points_and_one = np.column_stack([points, np.ones(len(points))])
    return [_polygon(part, points_and_one) for part in _joined(list(_parts(mesh, points, places)), points_and_one)]


def _position_numbers(vertices: npt.NDArray[np.float32]) -> list[int]:
    first: dict[bytes, int] = {}
    tidy = np.ascontiguousarray(vertices + np.float32(0.0))  # -0.0 and 0.0 are the same position
    return [first.setdefault(row.tobytes(), number) for number, row in enumerate(tidy)]


def _parts(mesh: Mesh, points: Vector, places: list[int]) -> Iterator[_FlatPart]:
    """Yield the triangles; those without an area are left out."""
    a, b, c = (points[mesh.triangles[:, i]] for i in range(3))
    normals = cross(b - a, c - a)
    areas = np.linalg.norm(normals, axis=1)
    kept = areas > 1e-10
    a, b, c, areas, triangles = a[kept], b[kept], c[kept], areas[kept, None], mesh.triangles[kept]
    normals = normals[kept] / areas
    values = np.concatenate([mesh.uvs, mesh.normals], axis=1).astype(np.float64)[triangles]
    # The gradients, in the triangle's plane, of functions with these values at its corners.
    along, across = cross(c - a, normals) / areas, cross(normals, b - a) / areas
    factors = (values[:, 1] - values[:, 0])[:, :, None] * along[:, None]
    factors += (values[:, 2] - values[:, 0])[:, :, None] * across[:, None]
    constants = values[:, 0] - np.einsum("ijk,ik->ij", factors, a)
    functions = np.concatenate([factors, constants[:, :, None]], axis=2)
    distances = np.einsum("ij,ij->i", normals, a)
    for i, corners in enumerate(triangles.tolist()):
        yield _FlatPart([places[corner] for corner in corners], normals[i], float(distances[i]), functions[i])


def _joined(parts: list[_FlatPart], points: Vector) -> list[_FlatPart]:
    """Merge neighbours until no more can be merged."""
    edges = {edge: part for part in parts for edge in _edges(part.corners)}
    gone: set[int] = set()
    for part in parts:
        if id(part) in gone:
            continue
        grown = True
        while grown:
            grown = False
            for a, b in _edges(part.corners):
                other = edges.get((b, a))
                if other is None or other is part or id(other) in gone:
                    continue
                corners = _union(part, other, (a, b), points)
                if corners:
                    part.corners = corners
                    gone.add(id(other))
                    edges.update(dict.fromkeys(_edges(corners), part))
                    grown = True
                    break
    return [part for part in parts if id(part) not in gone]


def _edges(corners: list[int]) -> list[tuple[int, int]]:
    return list(zip(corners, corners[1:] + corners[:1], strict=True))


def _union(part: _FlatPart, other: _FlatPart, edge: tuple[int, int], points: Vector) -> list[int]:
    """Return the corners of both as one convex polygon; empty if they cannot be merged."""
    if len(part.corners) + len(other.corners) - 2 > _MOST_CORNERS or part.normal @ other.normal < 0.99999:
        return []
    at = part.corners.index(edge[0])
    turn = other.corners.index(edge[0])
    between = (other.corners[turn:] + other.corners[:turn])[1:-1]
    corners = part.corners[: at + 1] + between + part.corners[at + 1 :]
    if len(set(corners)) < len(corners):
        return []
    here = points[corners]
    places = np.ascontiguousarray(here[:, :3])
    if np.abs(places @ part.normal - part.distance).max() > _FLAT:
        return []
    apart = np.abs(here @ (part.functions - other.functions).T).max(axis=0)
    if apart[:2].max() > _SAME_UV or apart[2:].max() > _SAME_NORMAL:
        return []
    return corners if _is_convex(places, part.normal) else []


def _is_convex(places: Vector, normal: Vector) -> bool:
    """Return whether an outline never turns right, seen against the normal, nor back on itself."""
    steps = successors(places) - places
    steps = steps[np.abs(steps).max(axis=1) > _SAME_PLACE]
    after = successors(steps)
    turns, along = cross(steps, after) @ normal, (steps * after).sum(axis=1)
    return bool((turns > -1e-9).all() and ((along > 0.0) | (turns > 1e-3 * -along)).all())


def _polygon(part: _FlatPart, points: Vector) -> Polygon:
    functions = part.functions.copy()
    functions[1] *= -1.0  # rows run downwards
    places = points[part.corners]
    functions[:2, 3] -= np.floor((places @ functions[:2].T).min(axis=0) + 1e-6)
    normals = places @ functions[2:].T
    smooth = bool((normals.max(axis=0) - normals.min(axis=0)).max() > 1e-4)
    if not smooth:
        functions[2:, :3], functions[2:, 3] = 0.0, normals[0]
    spread = float(np.linalg.norm(cross(functions[0, :3], functions[1, :3])))
    if np.abs(functions[:2, :3]).max() < 1e-6:
        functions[:2, :3] = spread = 0.0
    plane = np.concatenate([part.normal, [part.distance], functions[0], functions[1], [spread], functions[2:].ravel()])
    return Polygon(tuple(part.corners), plane, smooth)
