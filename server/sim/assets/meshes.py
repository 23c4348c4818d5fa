"""Primitive meshes (boxes, solids of revolution, tubes, plates) and transformations of meshes.

All shapes are in the body's own frame (X right, Y ahead, Z up), wind counter-clockwise seen from outside, and have
non-negative texture coordinates. `per_texture` is the size of one texture on the surface, in units.
"""

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from arramon_server.sim.scene import Mesh
from arramon_server.sim.vectors import cross

Vector = tuple[float, float, float]
_CREASE = math.cos(math.radians(40.0))
"""Cosine of the largest bend (40 degrees) between neighbouring rings of a lathe that is shaded smoothly."""


def merge(*parts: Mesh) -> Mesh:
    """Merge meshes into one."""
    starts = np.cumsum([0, *(len(part.vertices) for part in parts[:-1])])
    return Mesh(
        vertices=np.concatenate([part.vertices for part in parts]),
        uvs=np.concatenate([part.uvs for part in parts]),
        normals=np.concatenate([part.normals for part in parts]),
        triangles=np.concatenate([part.triangles + np.int32(s) for part, s in zip(parts, starts, strict=True)]),
    )


def moved(mesh: Mesh, offset: Vector = (0.0, 0.0, 0.0), turn: float = 0.0, pitch: float = 0.0) -> Mesh:
    """Return the mesh pitched about its X axis, then turned clockwise seen from above, then shifted.

    `pitch` (front up) and `turn` are in degrees.
    """
    a, b = math.radians(pitch), math.radians(-turn)
    about_x = np.array([[1, 0, 0], [0, math.cos(a), -math.sin(a)], [0, math.sin(a), math.cos(a)]])
    about_z = np.array([[math.cos(b), -math.sin(b), 0], [math.sin(b), math.cos(b), 0], [0, 0, 1]])
    rotation = (about_z @ about_x).astype(np.float32)
    shift = np.asarray(offset, np.float32)
    return Mesh(mesh.vertices @ rotation.T + shift, mesh.uvs, mesh.normals @ rotation.T, mesh.triangles)


def stretched(mesh: Mesh, x: float, y: float, z: float) -> Mesh:
    """Return the mesh scaled along each axis (all factors above 0)."""
    factors = np.array([x, y, z], np.float32)
    normals = mesh.normals / factors
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return Mesh(mesh.vertices * factors, mesh.uvs, normals, mesh.triangles)


def painted(mesh: Mesh, uv: tuple[float, float]) -> Mesh:
    """Return the mesh in a single colour, that of its texture at `uv`."""
    return Mesh(mesh.vertices, np.full_like(mesh.uvs, uv), mesh.normals, mesh.triangles)


def mapped(mesh: Mesh, u: tuple[float, float], v: tuple[float, float]) -> Mesh:
    """Return the mesh with its texture coordinates mapped from [0, 1] to the ranges `u` and `v`."""
    low = np.array([u[0], v[0]], np.float32)
    size = np.array([u[1] - u[0], v[1] - v[0]], np.float32)
    return Mesh(mesh.vertices, low + mesh.uvs * size, mesh.normals, mesh.triangles)


def quad(corners: Sequence[Vector], u: tuple[float, float] = (0.0, 1.0), v: tuple[float, float] = (0.0, 1.0)) -> Mesh:
    """Build a flat quadrilateral.

    Args:
        corners: bottom left, bottom right, top right, top left, as seen from its front.
        u: u of the left and the right edge.
        v: v of the lower and the upper edge.
    """
    points = np.asarray(corners, np.float32)
    normal = cross(points[1] - points[0], points[3] - points[0])
    normal = normal / np.linalg.norm(normal)
    uvs = np.array([(u[0], v[0]), (u[1], v[0]), (u[1], v[1]), (u[0], v[1])], np.float32)
    triangles = np.array([(0, 1, 2), (0, 2, 3)], np.int32)
    return Mesh(points, uvs, np.tile(normal, (4, 1)).astype(np.float32), triangles)


def box(width: float, length: float, height: float, base: float = 0.0, per_texture: float = 1.0) -> Mesh:
    """Build a box centred on the Z axis, without an underside if it is on the ground.

    Args:
        width: size along X.
        length: size along Y.
        height: size along Z.
        base: height of its underside.
        per_texture: units per texture.
    """
    x, y, low, high = width / 2, length / 2, base, base + height
    across, along, up = width / per_texture, length / per_texture, height / per_texture
    faces = [
        quad([(-x, -y, low), (x, -y, low), (x, -y, high), (-x, -y, high)], (0, across), (0, up)),
        quad([(x, -y, low), (x, y, low), (x, y, high), (x, -y, high)], (0, along), (0, up)),
        quad([(x, y, low), (-x, y, low), (-x, y, high), (x, y, high)], (0, across), (0, up)),
        quad([(-x, y, low), (-x, -y, low), (-x, -y, high), (-x, y, high)], (0, along), (0, up)),
        quad([(-x, -y, high), (x, -y, high), (x, y, high), (-x, y, high)], (0, across), (0, along)),
    ]
    if base > 0.0:
        faces.append(quad([(x, -y, low), (-x, -y, low), (-x, y, low), (x, y, low)], (0, across), (0, along)))
    return merge(*faces)


def lathe(
    profile: Sequence[tuple[float, float]], sides: int = 14, around: float = 1.0, per_texture: float = 1.0
) -> Mesh:
    """Build a solid of revolution about the Z axis.

    Args:
        profile: (radius, height) pairs; the outside lies to the right of the direction in which they run, so an outside
            runs upwards and the inside of a cup downwards.
        sides: number of sides of the polygon that approximates the circle.
        around: number of textures around the axis, a whole number if the texture must be seamless.
        per_texture: units per texture along the outline.
    """
    ring = np.linspace(0.0, 2 * math.pi, sides + 1)
    outwards = np.stack([np.cos(ring), np.sin(ring)], axis=1)
    bands, travelled = [], 0.0
    slopes = [_slope(a, b) for a, b in pairwise(profile)]
    for i, ((r0, z0), (r1, z1)) in enumerate(pairwise(profile)):
        length = math.hypot(r1 - r0, z1 - z0)
        first = _joint(slopes[i - 1], slopes[i]) if i > 0 else slopes[i]
        last = _joint(slopes[i + 1], slopes[i]) if i + 1 < len(slopes) else slopes[i]
        rings = [
            (r0, z0, first, travelled / per_texture),
            (r1, z1, last, (travelled + length) / per_texture),
        ]
        bands.append(_band(rings, outwards, ring * around / (2 * math.pi)))
        travelled += length
    return merge(*bands)


def _slope(a: tuple[float, float], b: tuple[float, float]) -> tuple[float, float]:
    """Return the outline's normal, (outwards, up)."""
    length = math.hypot(b[0] - a[0], b[1] - a[1])
    return (b[1] - a[1]) / length, (a[0] - b[0]) / length


def _joint(other: tuple[float, float], own: tuple[float, float]) -> tuple[float, float]:
    """Return the normal where two segments of the outline meet: shared at a gentle bend, else the segment's own."""
    if other[0] * own[0] + other[1] * own[1] < _CREASE:
        return own
    out, up = other[0] + own[0], other[1] + own[1]
    return out / math.hypot(out, up), up / math.hypot(out, up)


def _band(
    rings: Sequence[tuple[float, float, tuple[float, float], float]],
    outwards: npt.NDArray[np.float64],
    u: npt.NDArray[np.float64],
) -> Mesh:
    """Build the strip between two rings, each (radius, height, normal as (outwards, up), v)."""
    sides = len(u) - 1
    vertices, normals, uvs = [], [], []
    for radius, height, (out, up), v in rings:
        vertices.append(np.column_stack([outwards * radius, np.full(sides + 1, height)]))
        normals.append(np.column_stack([outwards * out, np.full(sides + 1, up)]))
        uvs.append(np.column_stack([u, np.full(sides + 1, v)]))
    i = np.arange(sides)
    lower = np.column_stack([i, i + 1, i + sides + 2])
    upper = np.column_stack([i, i + sides + 2, i + sides + 1])
    # A ring of radius 0 is a point: half of the triangles there would have no area.
    triangles = [lower] * (rings[0][0] > 0.0) + [upper] * (rings[1][0] > 0.0)
    return Mesh(
        np.concatenate(vertices).astype(np.float32),
        np.concatenate(uvs).astype(np.float32),
        np.concatenate(normals).astype(np.float32),
        np.concatenate(triangles).astype(np.int32),
    )


def ball(radius: float, height: float, sides: int = 14, rings: int = 8, per_texture: float = 1.0) -> Mesh:
    """Build a sphere whose centre is at `height`."""
    angles = np.linspace(-math.pi / 2, math.pi / 2, rings + 1)
    profile = [
        (radius * abs(math.cos(a)) if 0 < i < rings else 0.0, height + radius * math.sin(a))
        for i, a in enumerate(angles)
    ]
    return lathe(profile, sides, per_texture=per_texture)


def tube(path: Sequence[Vector], radius: float, sides: int = 5) -> Mesh:
    """Build a pipe along a path, open at its ends; one texture around and one along."""
    points = np.asarray(path, np.float64)
    tangents = np.gradient(points, axis=0)
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    # Any direction that is not parallel to a tangent of the path.
    helper = np.eye(3)[int(np.argmin(np.abs(tangents).max(axis=0)))]
    side = np.cross(tangents, helper)
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    other = np.cross(tangents, side)
    ring = np.linspace(0.0, 2 * math.pi, sides + 1)
    normals = side[:, None] * np.cos(ring)[None, :, None] + other[:, None] * np.sin(ring)[None, :, None]
    vertices = points[:, None] + radius * normals
    u, v = np.meshgrid(np.linspace(0, 1, sides + 1), np.linspace(0, 1, len(points)))
    start = (np.arange(len(points) - 1)[:, None] * (sides + 1) + np.arange(sides)).reshape(-1)
    triangles = np.concatenate(
        [
            np.column_stack([start, start + 1, start + sides + 2]),
            np.column_stack([start, start + sides + 2, start + sides + 1]),
        ]
    )
    return Mesh(
        vertices.reshape(-1, 3).astype(np.float32),
        np.stack([u, v], axis=-1).reshape(-1, 2).astype(np.float32),
        normals.reshape(-1, 3).astype(np.float32),
        triangles.astype(np.int32),
    )


def arc(centre: Vector, radius: float, start: float, end: float, pieces: int = 8) -> list[Vector]:
    """Return points on a circle in the X-Z plane, from `start` to `end` degrees (0 along +X, 90 up)."""
    angles = np.radians(np.linspace(start, end, pieces + 1))
    return [(centre[0] + radius * math.cos(a), centre[1], centre[2] + radius * math.sin(a)) for a in angles]


def plate(outline: Sequence[tuple[float, float]], thickness: float) -> tuple[Mesh, Mesh, Mesh]:
    """Build a convex plate in the X-Z plane, facing +Y.

    Args:
        outline: its corners (x, z), counter-clockwise as seen from behind, looking along +Y.
        thickness: along Y, centred on the X-Z plane.

    Returns:
        Its front, its back and its rim; front and back have their texture fitted to the outline's bounding box.
    """
    points = np.asarray(outline, np.float64)
    low, size = points.min(axis=0), np.ptp(points, axis=0)
    n, y = len(points), thickness / 2
    fan = np.column_stack([np.zeros(n - 2), np.arange(1, n - 1), np.arange(2, n)]).astype(np.int32)
    uvs = (points - low) / size
    faces = []
    for sign, order in ((1.0, fan[:, ::-1]), (-1.0, fan)):
        # Seen from +Y, the body's +X is on the left.
        mirrored = np.column_stack([1.0 - uvs[:, 0], uvs[:, 1]]) if sign > 0 else uvs
        vertices = np.column_stack([points[:, 0], np.full(n, sign * y), points[:, 1]])
        normals = np.tile([0.0, sign, 0.0], (n, 1))
        vertices, mirrored, normals = (array.astype(np.float32) for array in (vertices, mirrored, normals))
        faces.append(Mesh(vertices, mirrored, normals, order.astype(np.int32)))
    rim = [
        quad([(b[0], -y, b[1]), (b[0], y, b[1]), (a[0], y, a[1]), (a[0], -y, a[1])])
        for a, b in zip(np.roll(points, -1, axis=0).tolist(), points.tolist(), strict=True)
    ]
    return faces[0], faces[1], merge(*rim)
