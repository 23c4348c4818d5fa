"""The rasteriser's first pass, compiled: the nearest polygon of each pixel, and its inverse depth.

Every polygon in view writes its inverse depth and its number into the pixels whose centres it covers; the nearest wins,
of equally near ones the later in the scene. Clusters are drawn front to back, and skipped if they are hidden. The
arithmetic is plain IEEE in one thread, in the order of the code, so that it is deterministic.
"""

import math

import numpy as np
import numpy.typing as npt

from arramon_server.sim.raster.arrays import Bodies, Doubles, Floats, FrameConstants, Geometry, Integers, Scratch
from arramon_server.sim.raster.compilation import cached, inlined

_I32, _I64, _U64, _F32 = np.int32, np.int64, np.uint64, np.float32

_FULL = 4096
"""Brightness that does not change a colour."""

_THINNEST = 1e-4
"""Polygons whose plane is nearer to the eye than this, in the body's units, are skipped: they are seen edge-on."""

_View = tuple[float, float, float, float, float]
"""X, Y, Z of the eye in the scene, cosine and sine of its heading."""

_Eye = tuple[float, float, float, float, float, float, float, float]
"""The eye in a body's own frame: X, Y, Z, the direction ahead (X, Y); the body's scale, cosine and sine."""

_Look = tuple[int, int, int, int, int, int]
"""Number of a body's first polygon; texture and label; the texture's first texel, width and height."""


@cached
def cover(
    view: _View,
    setting: FrameConstants,
    geometry: Geometry,
    places: Integers,
    bodies: Bodies,
    actor_places: Integers,
    actors: Bodies,
    work: Scratch,
) -> None:
    """Fill in `work.keys`, and for the polygons named there `work.functions` and `work.marks`.

    Args:
        view: pose of the eye.
        setting: constants of the frame.
        geometry: meshes of the bodies and the actors.
        places: `Textures.places` of the bodies.
        bodies: bodies of the scene.
        actor_places: `Textures.places` of the actors.
        actors: actors of this frame.
        work: buffers, overwritten.
    """
    work.keys[:] = _I64(_F32(1.0 / setting.far).view(_I32)) << _I64(32)
    seen = _gather(view, setting, geometry, bodies, 0, 0, work)
    seen = _gather(view, setting, geometry, actors, 1, seen, work)
    _sort(work.order, work.distances, seen)
    for i in range(seen):
        group, body, cluster = work.order[i, 0], work.order[i, 1], work.order[i, 2]
        if group == 0:
            eye, mesh, look = _eye(view, bodies, body), int(bodies[body, 6]), _look(bodies, body, places)
        else:
            eye, mesh, look = _eye(view, actors, body), int(actors[body, 6]), _look(actors, body, actor_places)
        whole = work.distances[i] > setting.near
        if not (whole and _is_hidden(eye, setting, geometry.spheres, cluster, work.keys)):
            number = look[0] - geometry.clusters[geometry.meshes[mesh, 0], 1]
            _cover_cluster(eye, setting, geometry, cluster, whole, look, group, work, number)


@inlined
def _eye(view: _View, bodies: Bodies, body: int) -> _Eye:
    x, y, z, eye_cos, eye_sin = view
    cos, sin, scale = bodies[body, 3], bodies[body, 4], bodies[body, 5]
    east, north, up = (x - bodies[body, 0]) / scale, (y - bodies[body, 1]) / scale, (z - bodies[body, 2]) / scale
    ahead_x, ahead_y = eye_sin * cos - eye_cos * sin, eye_sin * sin + eye_cos * cos
    return east * cos - north * sin, east * sin + north * cos, up, ahead_x, ahead_y, scale, cos, sin


@inlined
def _look(bodies: Bodies, body: int, places: Integers) -> _Look:
    texture, label, first = int(bodies[body, 7]), int(bodies[body, 8]), int(bodies[body, 9])
    return first, texture, label, places[texture, 0], places[texture, 1], places[texture, 2]


@inlined
def _ahead(eye: _Eye, spheres: Floats, cluster: int) -> tuple[float, float, float, float]:
    """Return a cluster's sphere relative to the eye: right, up, ahead and radius, in body units."""
    x, y, up = spheres[cluster, 0] - eye[0], spheres[cluster, 1] - eye[1], spheres[cluster, 2] - eye[2]
    return x * eye[4] - y * eye[3], up, x * eye[3] + y * eye[4], spheres[cluster, 3]


@inlined
def _nearest(eye: _Eye, setting: FrameConstants, spheres: Floats, cluster: int) -> float:
    """Return a lower bound of a cluster's distance ahead of the eye, in units; infinite if it is outside the frame."""
    right, up, ahead, radius = _ahead(eye, spheres, cluster)
    half = 0.5 * setting.size
    slant = math.sqrt(setting.focal * setting.focal + half * half)
    outside = max(abs(right), abs(up)) * (setting.focal / slant) - ahead * (half / slant) > radius
    if outside or (ahead + radius) * eye[5] < setting.near:
        return math.inf
    return float((ahead - radius) * eye[5])


@inlined
def _gather(
    view: _View,
    setting: FrameConstants,
    geometry: Geometry,
    bodies: Bodies,
    group: int,
    seen: int,
    work: Scratch,
) -> int:
    """Append the clusters in view to `work.order`; return their total number."""
    for body in range(len(bodies)):
        eye, mesh = _eye(view, bodies, body), int(bodies[body, 6])
        for cluster in range(geometry.meshes[mesh, 0], geometry.meshes[mesh, 1]):
            nearest = _nearest(eye, setting, geometry.spheres, cluster)
            if nearest < setting.far:
                work.order[seen, 0], work.order[seen, 1], work.order[seen, 2] = group, body, cluster
                work.distances[seen] = nearest
                seen += 1
    return seen


@inlined
def _sort(order: Integers, distances: Doubles, n: int) -> None:
    """Sort by distance: near clusters hide far ones, which then need not be drawn."""
    for i in range(1, n):
        distance, group, body, cluster = distances[i], order[i, 0], order[i, 1], order[i, 2]
        at = i
        while at > 0 and distances[at - 1] > distance:
            distances[at] = distances[at - 1]
            order[at, 0], order[at, 1], order[at, 2] = order[at - 1, 0], order[at - 1, 1], order[at - 1, 2]
            at -= 1
        distances[at] = distance
        order[at, 0], order[at, 1], order[at, 2] = group, body, cluster


@inlined
def _is_hidden(eye: _Eye, setting: FrameConstants, spheres: Floats, cluster: int, keys: npt.NDArray[np.int64]) -> bool:
    """Return whether all pixels that a cluster can cover are nearer than the cluster, which must be wholly ahead."""
    right, up, ahead, radius = _ahead(eye, spheres, cluster)
    left, end = _reach(right, ahead, radius, setting)
    top, bottom = _reach(-up, ahead, radius, setting)
    limit = _I64(_F32(1.0 / ((ahead - radius) * eye[5])).view(_I32)) << _I64(32)
    for row in range(top, bottom):
        lowest = limit
        for i in range(_U64(row * setting.size + left), _U64(row * setting.size + end)):
            lowest = min(lowest, keys[i])
        if lowest < limit:
            return False
    return True


@inlined
def _reach(place: float, ahead: float, radius: float, setting: FrameConstants) -> tuple[int, int]:
    """Return the first and end pixel that a sphere can cover, along one axis of the image."""
    low, high = place - radius, place + radius
    low /= ahead + radius if low > 0.0 else ahead - radius
    high /= ahead - radius if high > 0.0 else ahead + radius
    middle, limit = 0.5 * setting.size, float(setting.size)
    start = min(max(middle + low * setting.focal - 1.0, 0.0), limit)
    return int(start), int(min(max(middle + high * setting.focal + 2.0, start), limit))


@inlined
def _cover_cluster(
    eye: _Eye,
    setting: FrameConstants,
    geometry: Geometry,
    cluster: int,
    whole: bool,
    look: _Look,
    group: int,
    work: Scratch,
    number: int,
) -> None:
    """Draw a cluster, `whole` if it is wholly beyond the near plane; `number` is added to its polygons' indices."""
    first, end = geometry.clusters[cluster, 0], geometry.clusters[cluster, 2]
    _project(eye, setting, geometry.points, first, end, work.points, work.pixels)
    for polygon in range(geometry.clusters[cluster, 1], geometry.clusters[cluster, 3]):
        planes = geometry.planes
        over = (
            planes[polygon, 0] * eye[0] + planes[polygon, 1] * eye[1] + planes[polygon, 2] * eye[2] - planes[polygon, 3]
        )
        if over <= _THINNEST:
            continue
        corner, corners = geometry.shapes[polygon, 0], geometry.shapes[polygon, 1]
        outline = geometry.corners
        if not whole:
            corners = _clip(outline, corner, corners, setting.near / eye[5], end - first, setting, work)
            outline, corner = work.outline, 0
        top, bottom = _rows(outline, corner, corners, work.pixels)
        if top < bottom:
            _edges(outline, corner, corners, setting.size, work.points, work.pixels, work.spans)
            _fill(eye, setting, planes, polygon, over, top, bottom, work, number + polygon)
            curved = geometry.shapes[polygon, 2]
            _describe(eye, setting, planes, polygon, curved, look, group, over, work, number + polygon)


@inlined
def _project(
    eye: _Eye, setting: FrameConstants, points: Floats, first: int, end: int, projected: Doubles, pixels: Integers
) -> None:
    middle, focal, limit = 0.5 * setting.size, setting.focal, float(setting.size)
    for i in range(end - first):
        at = first + i
        x, y, up = points[at, 0] - eye[0], points[at, 1] - eye[1], points[at, 2] - eye[2]
        ahead, right = x * eye[3] + y * eye[4], x * eye[4] - y * eye[3]
        by = focal / ahead
        column, row = middle + right * by, middle - up * by
        projected[i, 0], projected[i, 1], projected[i, 2] = right, up, ahead
        projected[i, 3], projected[i, 4] = column, row
        pixels[i, 0], pixels[i, 1] = _centre(column, limit), _centre(row, limit)


@inlined
def _clip(corners: Integers, first: int, n: int, near: float, free: int, setting: FrameConstants, work: Scratch) -> int:
    """Clip a polygon at the near plane into `work`, with new points from index `free`; return the number of corners."""
    points, pixels, outline = work.points, work.pixels, work.outline
    middle, by, limit = 0.5 * setting.size, setting.focal / near, float(setting.size)
    before = corners[first + n - 1]
    kept = 0
    for i in range(first, first + n):
        corner = corners[i]
        seen = points[corner, 2] >= near
        if (points[before, 2] >= near) != seen:
            # From the visible end, so that neighbours cut their common edge at the same point.
            a, b = (corner, before) if seen else (before, corner)
            part = (points[a, 2] - near) / (points[a, 2] - points[b, 2])
            points[free, 3] = middle + by * (points[a, 0] + part * (points[b, 0] - points[a, 0]))
            points[free, 4] = middle - by * (points[a, 1] + part * (points[b, 1] - points[a, 1]))
            pixels[free, 0], pixels[free, 1] = _centre(points[free, 3], limit), _centre(points[free, 4], limit)
            outline[kept] = free
            kept, free = kept + 1, free + 1
        if seen:
            outline[kept] = corner
            kept += 1
        before = corner
    return kept


@inlined
def _centre(place: float, size: float) -> np.int32:
    """Return the first pixel whose centre is not before a position, along one axis of the image."""
    return _I32(math.ceil(min(max(place - 0.5, 0.0), size)))


@inlined
def _rows(outline: Integers, first: int, n: int, pixels: Integers) -> tuple[int, int]:
    """Return the first and end row in which an outline may cover pixel centres."""
    if n < 3:
        return 0, 0
    left = right = pixels[outline[first], 0]
    top = bottom = pixels[outline[first], 1]
    for i in range(first + 1, first + n):
        column, row = pixels[outline[i], 0], pixels[outline[i], 1]
        left, right = min(left, column), max(right, column)
        top, bottom = min(top, row), max(bottom, row)
    return (top, bottom) if left < right else (0, 0)


@inlined
def _edges(
    outline: Integers, first: int, n: int, size: int, points: Doubles, pixels: Integers, spans: Integers
) -> None:
    """Fill in the first and end column of each row."""
    limit = float(size)
    before = outline[first + n - 1]
    for i in range(first, first + n):
        corner = outline[i]
        start, end = pixels[before, 1], pixels[corner, 1]
        if start != end:
            # A front-facing polygon is to the right of its downward edges. All edges are traversed downwards.
            side, high, low = (0, before, corner) if start < end else (1, corner, before)
            slope = (points[low, 3] - points[high, 3]) / (points[low, 4] - points[high, 4])
            base = points[high, 3] + (0.5 - points[high, 4]) * slope
            for row in range(min(start, end), max(start, end)):
                spans[row, side] = _centre(base + row * slope, limit)
        before = corner


@inlined
def _across(eye: _Eye, setting: FrameConstants, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Return a body-frame gradient in image space: per column, per row, and its value at the first pixel's centre."""
    column, row = (x * eye[4] - y * eye[3]) / setting.focal, -z / setting.focal
    return column, row, x * eye[3] + y * eye[4] - (0.5 * setting.size - 0.5) * (column + row)


@inlined
def _fill(
    eye: _Eye,
    setting: FrameConstants,
    planes: Floats,
    polygon: int,
    over: float,
    top: int,
    bottom: int,
    work: Scratch,
    number: int,
) -> None:
    """Write a polygon into the pixels in which it is the nearest."""
    keys, spans = work.keys, work.spans
    column, row, first = _across(eye, setting, planes[polygon, 0], planes[polygon, 1], planes[polygon, 2])
    by = -1.0 / (over * eye[5])
    step, mark = _F32(column * by), _I64(number)
    work.functions[number, 13] = step
    for y in range(top, bottom):
        start, end = spans[y, 0], spans[y, 1]
        base = _F32((first + row * y + column * start) * by)
        at = _U64(y * setting.size + start)
        for i in range(_U64(max(end - start, 0))):
            key = (_I64(_F32(base + step * _F32(_I32(i))).view(_I32)) << _I64(32)) | mark
            keys[at + i] = max(keys[at + i], key)


@inlined
def _describe(
    eye: _Eye,
    setting: FrameConstants,
    planes: Floats,
    polygon: int,
    curved: int,
    look: _Look,
    group: int,
    over: float,
    work: Scratch,
    number: int,
) -> None:
    """Write a polygon's data for the second pass."""
    _, texture, label, first, width, height = look
    functions, marks, f = work.functions, work.marks, polygon
    patterned = planes[f, 12] != 0.0
    marks[number, 0], marks[number, 1] = 2 * curved + patterned, texture
    marks[number, 2], marks[number, 5] = label, group
    if patterned:
        for i in (4, 8):
            x, y, z, constant = planes[f, i], planes[f, i + 1], planes[f, i + 2], planes[f, i + 3]
            _note(eye, setting, x, y, z, constant, functions, number, i - 4)
        pixel = setting.focal * setting.focal * over * eye[5] * eye[5] * eye[5]
        functions[number, 12] = planes[f, 12] * width * height / pixel
    else:
        marks[number, 4] = first + int(planes[f, 11] * height) * width + int(planes[f, 7] * width)
    cos, sin, sun_z = eye[6], eye[7], setting.sun[2]
    sun_x, sun_y = setting.sun[0] * cos - setting.sun[1] * sin, setting.sun[0] * sin + setting.sun[1] * cos
    facing = sun_x * planes[f, 16] + sun_y * planes[f, 20] + sun_z * planes[f, 24]
    marks[number, 3] = _I32((setting.ambient + setting.diffuse * max(facing, 0.0)) * _FULL)
    if curved:
        x = sun_x * planes[f, 13] + sun_y * planes[f, 17] + sun_z * planes[f, 21]
        y = sun_x * planes[f, 14] + sun_y * planes[f, 18] + sun_z * planes[f, 22]
        z = sun_x * planes[f, 15] + sun_y * planes[f, 19] + sun_z * planes[f, 23]
        _note(eye, setting, x, y, z, facing, functions, number, 8)


@inlined
def _note(
    eye: _Eye,
    setting: FrameConstants,
    x: float,
    y: float,
    z: float,
    constant: float,
    functions: Floats,
    number: int,
    first: int,
) -> None:
    """Write an affine function of the position in the body's frame as a function of the image position."""
    column, row, corner = _across(eye, setting, x, y, z)
    scale = eye[5]
    functions[number, first], functions[number, first + 1] = column / scale, row / scale
    functions[number, first + 2] = corner / scale
    functions[number, first + 3] = x * eye[0] + y * eye[1] + z * eye[2] + constant
