"""The compiled part of the rasteriser: from flattened scenes to pictures, in two passes.

First every polygon in view puts its nearness and its number into the pixels that it covers, and the nearest wins (of
equally near ones the later in the scene). Then every row is painted once, in runs of one polygon. The arithmetic is
plain IEEE, in one thread and in the order in which it is written here: the same arguments give the same bytes.

All compiled functions are in this file, long as it is: the code on disk is renewed when this file changes, and only
then. Loops over pixels are written for the compiler's vectoriser: in 32 bits, without branches, few arrays in each.
"""

import math
from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba
import numpy as np
import numpy.typing as npt
from numba.core.options import DefaultOptions

from server.sim.raster_arrays import Bodies, Doubles, Floats, Geometry, Integers, Scratch, Setting, Textures

_F = TypeVar("_F", bound=Callable[..., Any])

_I32, _I64, _U64, _F32, _F64 = np.int32, np.int64, np.uint64, np.float32, np.float64

_FULL = 4096
"""The brightness that leaves a colour as it is."""

_THINNEST = 1e-4
"""A polygon is left out when the eye is nearer to its plane than this, in its own units: it is seen edge-on."""

_Eye = tuple[float, float, float, float, float, float, float, float]
"""The eye as a body's own frame has it: X, Y, Z, the direction ahead (X, Y); the body's scale, cosine and sine."""

_Look = tuple[int, int, int, int, int, int]
"""The number of a body's first polygon; texture and label; the texture's first texel, width and height."""


_OPTIONS: dict[str, Any] = {"error_model": "numpy"}
if hasattr(DefaultOptions, "_nrt"):
    # No array is made here: without counting who refers to them, drawing takes two thirds of the time.
    _OPTIONS["_nrt"] = False


def _inlined(function: _F) -> _F:
    """Compiled into whoever calls it: passing groups of arrays on is dear."""
    return cast(_F, numba.njit(function, forceinline=True, **_OPTIONS))


def _draw(
    view: tuple[float, float, float, float, float],
    setting: Setting,
    geometry: Geometry,
    textures: Textures,
    bodies: Bodies,
    actor_textures: Textures,
    actors: Bodies,
    sky: Integers,
    work: Scratch,
    rgb: Integers,
    depth: npt.NDArray[np.uint16],
    labels: npt.NDArray[np.uint16],
) -> None:
    """Draws a frame.

    Args:
        view: X, Y, Z of the eye, cosine and sine of its heading.
        setting: of the frame.
        geometry: of the bodies and the actors.
        textures: of the bodies.
        bodies: of the scene.
        actor_textures: of the actors.
        actors: of this frame.
        sky: (size * size,) 0xBBGGRR, what is seen where nothing is.
        work: overwritten.
        rgb: (size * size * 3 / 4, rounded up,) is filled in: three bytes a pixel.
        depth: (size * size,) is filled in, as in `cameras.Frame`.
        labels: (size * size,) is filled in.
    """
    work.keys[:] = _I64(_F32(1.0 / setting.far).view(_I32)) << _I64(32)
    seen = _gather(view, setting, geometry, bodies, 0, 0, work)
    seen = _gather(view, setting, geometry, actors, 1, seen, work)
    _sort(work.order, work.distances, seen)
    for i in range(seen):
        group, body, cluster = work.order[i, 0], work.order[i, 1], work.order[i, 2]
        if group == 0:
            eye, look, mesh = (
                _eye(view, bodies.poses, body),
                _look(bodies.looks, body, textures.places),
                bodies.looks[body, 0],
            )
        else:
            eye, look, mesh = (
                _eye(view, actors.poses, body),
                _look(actors.looks, body, actor_textures.places),
                actors.looks[body, 0],
            )
        whole = work.distances[i] > setting.near
        if not (whole and _is_hidden(eye, setting, geometry.spheres, cluster, work.keys)):
            number = look[0] - geometry.clusters[geometry.meshes[mesh, 0], 1]
            _cover(eye, setting, geometry, cluster, whole, look, group, work, number)
    for y in range(setting.size):
        _paint_row(y, setting, textures, actor_textures, sky, work, labels)
        _measure_row(y * setting.size, setting.size, work.keys, depth)
        _light_row(y * setting.size, setting.size, work.colours, work.shades, work.lit)
    _pack(work.lit, rgb)


try:
    draw = numba.njit(cache=True, **_OPTIONS)(_draw)
except RuntimeError:  # there is no folder where the compiled code could be kept
    draw = numba.njit(**_OPTIONS)(_draw)


@_inlined
def _eye(view: tuple[float, float, float, float, float], poses: Doubles, body: int) -> _Eye:
    x, y, z, eye_cos, eye_sin = view
    cos, sin, scale = poses[body, 3], poses[body, 4], poses[body, 5]
    east, north, up = (x - poses[body, 0]) / scale, (y - poses[body, 1]) / scale, (z - poses[body, 2]) / scale
    ahead_x, ahead_y = eye_sin * cos - eye_cos * sin, eye_sin * sin + eye_cos * cos
    return east * cos - north * sin, east * sin + north * cos, up, ahead_x, ahead_y, scale, cos, sin


@_inlined
def _look(looks: Integers, body: int, places: Integers) -> _Look:
    texture = looks[body, 1]
    return looks[body, 3], texture, looks[body, 2], places[texture, 0], places[texture, 1], places[texture, 2]


@_inlined
def _ahead(eye: _Eye, spheres: Floats, cluster: int) -> tuple[float, float, float, float]:
    """A cluster's sphere as it is seen: its middle to the right, up, and ahead, and its radius, in the body's units."""
    x, y, up = spheres[cluster, 0] - eye[0], spheres[cluster, 1] - eye[1], spheres[cluster, 2] - eye[2]
    return x * eye[4] - y * eye[3], up, x * eye[3] + y * eye[4], spheres[cluster, 3]


@_inlined
def _nearest(eye: _Eye, setting: Setting, spheres: Floats, cluster: int) -> float:
    """How far ahead of the eye a cluster may begin, in units; infinitely far if it is outside the picture."""
    right, up, ahead, radius = _ahead(eye, spheres, cluster)
    half = 0.5 * setting.size
    slant = math.sqrt(setting.focal * setting.focal + half * half)
    outside = max(abs(right), abs(up)) * (setting.focal / slant) - ahead * (half / slant) > radius
    if outside or (ahead + radius) * eye[5] < setting.near:
        return math.inf
    return float((ahead - radius) * eye[5])


@_inlined
def _gather(
    view: tuple[float, float, float, float, float],
    setting: Setting,
    geometry: Geometry,
    bodies: Bodies,
    group: int,
    seen: int,
    work: Scratch,
) -> int:
    """Adds the clusters that are in the picture to `work.order`; returns how many there are then."""
    for body in range(len(bodies.poses)):
        eye = _eye(view, bodies.poses, body)
        mesh = bodies.looks[body, 0]
        for cluster in range(geometry.meshes[mesh, 0], geometry.meshes[mesh, 1]):
            nearest = _nearest(eye, setting, geometry.spheres, cluster)
            if nearest < setting.far:
                work.order[seen, 0], work.order[seen, 1], work.order[seen, 2] = group, body, cluster
                work.distances[seen] = nearest
                seen += 1
    return seen


@_inlined
def _sort(order: Integers, distances: Doubles, n: int) -> None:
    """Sorts by distance: what is near hides what is far, which then need not be drawn."""
    for i in range(1, n):
        distance, group, body, cluster = distances[i], order[i, 0], order[i, 1], order[i, 2]
        at = i
        while at > 0 and distances[at - 1] > distance:
            distances[at] = distances[at - 1]
            order[at, 0], order[at, 1], order[at, 2] = order[at - 1, 0], order[at - 1, 1], order[at - 1, 2]
            at -= 1
        distances[at] = distance
        order[at, 0], order[at, 1], order[at, 2] = group, body, cluster


@_inlined
def _is_hidden(eye: _Eye, setting: Setting, spheres: Floats, cluster: int, keys: npt.NDArray[np.int64]) -> bool:
    """Whether everything where a cluster can be seen is nearer than the cluster, which is wholly ahead."""
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


@_inlined
def _reach(place: float, ahead: float, radius: float, setting: Setting) -> tuple[int, int]:
    """From and to which pixel a sphere can reach, along a column or a row."""
    low, high = place - radius, place + radius
    low /= ahead + radius if low > 0.0 else ahead - radius
    high /= ahead - radius if high > 0.0 else ahead + radius
    middle, limit = 0.5 * setting.size, float(setting.size)
    start = min(max(middle + low * setting.focal - 1.0, 0.0), limit)
    return int(start), int(min(max(middle + high * setting.focal + 2.0, start), limit))


@_inlined
def _cover(
    eye: _Eye,
    setting: Setting,
    geometry: Geometry,
    cluster: int,
    whole: bool,
    look: _Look,
    group: int,
    work: Scratch,
    number: int,
) -> None:
    """The first pass of a cluster, `whole` if all of it is ahead; its polygons have their own numbers plus `number`."""
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


@_inlined
def _project(
    eye: _Eye, setting: Setting, points: Floats, first: int, end: int, projected: Doubles, pixels: Integers
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


@_inlined
def _clip(corners: Integers, first: int, n: int, near: float, free: int, setting: Setting, work: Scratch) -> int:
    """Puts the outline of what lies beyond the near plane into `work`, new points from `free`; returns how many."""
    points, pixels, outline = work.points, work.pixels, work.outline
    middle, by, limit = 0.5 * setting.size, setting.focal / near, float(setting.size)
    before = corners[first + n - 1]
    kept = 0
    for i in range(first, first + n):
        corner = corners[i]
        seen = points[corner, 2] >= near
        if (points[before, 2] >= near) != seen:
            # From the visible end, so that neighbours cut their common edge in the same place.
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


@_inlined
def _centre(place: float, size: float) -> np.int32:
    """The first pixel whose centre is not before a place on the picture, along a column or a row."""
    return _I32(math.ceil(min(max(place - 0.5, 0.0), size)))


@_inlined
def _rows(outline: Integers, first: int, n: int, pixels: Integers) -> tuple[int, int]:
    """From and to which row an outline may cover centres of pixels."""
    if n < 3:
        return 0, 0
    left = right = pixels[outline[first], 0]
    top = bottom = pixels[outline[first], 1]
    for i in range(first + 1, first + n):
        column, row = pixels[outline[i], 0], pixels[outline[i], 1]
        left, right = min(left, column), max(right, column)
        top, bottom = min(top, row), max(bottom, row)
    return (top, bottom) if left < right else (0, 0)


@_inlined
def _edges(
    outline: Integers, first: int, n: int, size: int, points: Doubles, pixels: Integers, spans: Integers
) -> None:
    """Fills in the columns from and to of each row."""
    limit = float(size)
    before = outline[first + n - 1]
    for i in range(first, first + n):
        corner = outline[i]
        start, end = pixels[before, 1], pixels[corner, 1]
        if start != end:
            # What is seen from its front is to the right of an edge that runs down. All edges are walked downwards.
            side, high, low = (0, before, corner) if start < end else (1, corner, before)
            slope = (points[low, 3] - points[high, 3]) / (points[low, 4] - points[high, 4])
            base = points[high, 3] + (0.5 - points[high, 4]) * slope
            for row in range(min(start, end), max(start, end)):
                spans[row, side] = _centre(base + row * slope, limit)
        before = corner


@_inlined
def _across(eye: _Eye, setting: Setting, x: float, y: float, z: float) -> tuple[float, float, float]:
    """What a gradient in the body's frame becomes on the picture: a column, a row, and at the first pixel's centre."""
    column, row = (x * eye[4] - y * eye[3]) / setting.focal, -z / setting.focal
    return column, row, x * eye[3] + y * eye[4] - (0.5 * setting.size - 0.5) * (column + row)


@_inlined
def _fill(
    eye: _Eye,
    setting: Setting,
    planes: Floats,
    polygon: int,
    over: float,
    top: int,
    bottom: int,
    work: Scratch,
    number: int,
) -> None:
    """Puts a polygon into the pixels where nothing is nearer."""
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


@_inlined
def _describe(
    eye: _Eye,
    setting: Setting,
    planes: Floats,
    polygon: int,
    curved: int,
    look: _Look,
    group: int,
    over: float,
    work: Scratch,
    number: int,
) -> None:
    """Notes what the second pass needs to know of a polygon."""
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


@_inlined
def _note(
    eye: _Eye,
    setting: Setting,
    x: float,
    y: float,
    z: float,
    constant: float,
    functions: Floats,
    number: int,
    first: int,
) -> None:
    """Writes down a function of the position, given in the body's frame, as one of the place on the picture."""
    column, row, corner = _across(eye, setting, x, y, z)
    scale = eye[5]
    functions[number, first], functions[number, first + 1] = column / scale, row / scale
    functions[number, first + 2] = corner / scale
    functions[number, first + 3] = x * eye[0] + y * eye[1] + z * eye[2] + constant


@_inlined
def _paint_row(
    y: int, setting: Setting, textures: Textures, actor_textures: Textures, sky: Integers, work: Scratch, labels: Any
) -> None:
    """Fills in colours and brightness of a row, and its labels, in runs of one polygon."""
    keys, colours, shades = work.keys, work.colours, work.shades
    line, end = _U64(y * setting.size), _U64(setting.size)
    x = _U64(0)
    while x < end:
        number = _I32(keys[line + x])
        start = x
        while x < end and _I32(keys[line + x]) == number:
            x += _U64(1)
        if number == 0:
            for i in range(start, x):
                colours[i], shades[i], labels[line + i] = sky[line + i], _I32(_FULL), 0
            continue
        label, kind, texture = np.uint16(work.marks[number, 2]), work.marks[number, 0], work.marks[number, 1]
        for i in range(start, x):
            labels[line + i] = label
        nearness = _I32(keys[line + start] >> _I64(32)).view(_F32)
        if work.marks[number, 5] == 0:
            _colour_run(textures, texture, nearness, kind, number, setting.levels, y, start, x, work)
        else:
            _colour_run(actor_textures, texture, nearness, kind, number, setting.levels, y, start, x, work)
        if kind & 2:
            _light_run(nearness, number, setting, y, start, x, work)
        else:
            shade = work.marks[number, 3]
            for i in range(start, x):
                shades[i] = shade


@_inlined
def _colour_run(
    textures: Textures,
    texture: int,
    nearness: Any,
    kind: int,
    number: Any,
    levels: int,
    y: int,
    start: Any,
    end: Any,
    work: Scratch,
) -> None:
    """Looks up the texels of a run; may write up to seven indices more to the right."""
    colours, indices, f, row = work.colours, work.indices, work.functions, _F32(y)
    if kind & 1 == 0:
        colour = textures.texels[work.marks[number, 4]]
        for x in range(start, end):
            colours[x] = colour
        return
    u_step, u_base, u_own = f[number, 0], f[number, 1] * row + f[number, 2], f[number, 3]
    v_step, v_base, v_own = f[number, 4], f[number, 5] * row + f[number, 6], f[number, 7]
    inside, near_step, from_column = f[number, 12], f[number, 13], _F32(_I32(start))
    first, width, rows = textures.places[texture, 0], textures.places[texture, 1], textures.places[texture, 3]
    wide, high, long = _F32(width), _F32(textures.places[texture, 2]), _F32(rows)
    last, coarsest = _I32(first + rows * width - 1), _I32(min(levels, textures.places[texture, 4]) - 1)
    for x in range(start, start + ((end - start + _U64(7)) & ~_U64(7))):
        column = _F32(_I32(x))
        distance = _F32(1.0) / (nearness + near_step * (column - from_column))
        u = u_own + distance * (u_base + u_step * column)
        v = v_own + distance * (v_base + v_step * column)
        u -= _F32(_I32(u))
        v -= _F32(_I32(v))
        # The level whose texels are about as large as a pixel: the rounded logarithm, to base 4, of the texels in it.
        texels = _F32(inside * distance * distance * distance)
        level = _I32(_I32(texels.view(_I32) >> _I32(23)) - _I32(126)) >> _I32(1)
        level = min(max(_I32(level), _I32(0)), coarsest)
        half = _I32(_I32(_I32(127) - level) << _I32(23)).view(_F32)  # as many halves as the level says
        line = _I32(_I32(long - long * half) + _I32(v * high * half))
        texel = _I32(_I32(first + _I32(line * width)) + _I32(u * wide * half))
        indices[x] = min(max(texel, first), last)
    for x in range(start, end):
        colours[x] = textures.texels[_U64(indices[x])]


@_inlined
def _light_run(nearness: Any, number: Any, setting: Setting, y: int, start: Any, end: Any, work: Scratch) -> None:
    """Finds the brightness of a run on a curved surface; may write up to seven more to the right."""
    f, shades = work.functions, work.shades
    step, base, own = f[number, 8], f[number, 9] * _F32(y) + f[number, 10], f[number, 11]
    near_step, from_column = f[number, 13], _F32(_I32(start))
    ambient, diffuse = _F32(setting.ambient * _FULL), _F32(setting.diffuse * _FULL)
    for x in range(start, start + ((end - start + _U64(7)) & ~_U64(7))):
        column = _F32(_I32(x))
        distance = _F32(1.0) / (nearness + near_step * (column - from_column))
        facing = own + distance * (base + step * column)
        shades[x] = _I32(ambient + diffuse * max(facing, _F32(0.0)))


@_inlined
def _measure_row(first: int, size: int, keys: npt.NDArray[np.int64], depth: npt.NDArray[np.uint16]) -> None:
    for i in range(_U64(first), _U64(first + size)):
        key = keys[i]
        nearness = _I32(key >> _I64(32)).view(_F32)
        thousandths = _I32(min(_F32(1000.0) / nearness + _F32(0.5), _F32(65535.0)))
        depth[i] = np.uint16(thousandths if _I32(key) != 0 else 0)


@_inlined
def _light_row(first: int, size: int, colours: Integers, shades: Integers, lit: Integers) -> None:
    line, byte = _U64(first), _I32(255)
    for i in range(_U64(size)):
        colour, shade = colours[i], shades[i]
        red = min(_I32(_I32(colour & byte) * shade) >> _I32(12), byte)
        green = min(_I32(_I32((colour >> _I32(8)) & byte) * shade) >> _I32(12), byte)
        blue = min(_I32(_I32(colour >> _I32(16)) * shade) >> _I32(12), byte)
        lit[line + i] = red | (green << _I32(8)) | (blue << _I32(16))


@_inlined
def _pack(lit: Integers, rgb: Integers) -> None:
    """Four pixels of four bytes each, one of them unused, are three words."""
    for i in range(_U64(len(rgb) // 3)):
        four, three = _U64(4) * i, _U64(3) * i
        a, b, c, d = lit[four], lit[four + _U64(1)], lit[four + _U64(2)], lit[four + _U64(3)]
        rgb[three] = a | _I32(b << _I32(24))
        rgb[three + _U64(1)] = (b >> _I32(8)) | _I32(c << _I32(16))
        rgb[three + _U64(2)] = (c >> _I32(16)) | _I32(d << _I32(8))
