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

from server.sim.raster_arrays import Bodies, Doubles, Floats, Geometry, Integers, Scratch, Setting, Textures

_F = TypeVar("_F", bound=Callable[..., Any])

_I32, _I64, _U64, _F32, _F64 = np.int32, np.int64, np.uint64, np.float32, np.float64

_FULL = 4096
"""The brightness that leaves a colour as it is."""

_THINNEST = 1e-4
"""A polygon is left out when the eye is nearer to its plane than this, in its own units: it is seen edge-on."""

_Eye = tuple[float, float, float, float, float, float, float, float]
"""The eye as a body's own frame has it: X, Y, Z, the direction ahead (X, Y); the body's scale, cosine and sine."""


def _inlined(function: _F) -> _F:
    """Compiled into whoever calls it: passing groups of arrays on is dear."""
    return cast(_F, numba.njit(function, error_model="numpy", forceinline=True))


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
        pose = bodies.poses[body] if group == 0 else actors.poses[body]
        look = bodies.looks[body] if group == 0 else actors.looks[body]
        texels = textures.texels if group == 0 else actor_textures.texels
        place = textures.places[look[1]] if group == 0 else actor_textures.places[look[1]]
        eye = _eye(view, pose)
        whole = work.distances[i] > setting.near
        if not (whole and _is_hidden(eye, setting, geometry.spheres[cluster], work.keys)):
            number = look[3] - geometry.clusters[geometry.meshes[look[0], 0], 1]
            _cover(eye, setting, geometry, cluster, whole, texels, place, look, group, work, number)
    for y in range(setting.size):
        _paint_row(y, setting, textures, actor_textures, sky, work, labels)
        _measure_row(y * setting.size, setting.size, work.keys, depth)
        _light_row(y * setting.size, setting.size, work.colours, work.shades, work.lit)
    _pack(work.lit, rgb)


try:
    draw = numba.njit(cache=True, error_model="numpy")(_draw)
except RuntimeError:  # there is no folder where the compiled code could be kept
    draw = numba.njit(error_model="numpy")(_draw)


@_inlined
def _eye(view: tuple[float, float, float, float, float], pose: Doubles) -> _Eye:
    x, y, z, eye_cos, eye_sin = view
    cos, sin, scale = pose[3], pose[4], pose[5]
    east, north, up = (x - pose[0]) / scale, (y - pose[1]) / scale, (z - pose[2]) / scale
    ahead_x, ahead_y = eye_sin * cos - eye_cos * sin, eye_sin * sin + eye_cos * cos
    return east * cos - north * sin, east * sin + north * cos, up, ahead_x, ahead_y, scale, cos, sin


@_inlined
def _nearest(eye: _Eye, setting: Setting, sphere: Floats) -> float:
    """How far ahead of the eye a sphere begins, in units; infinitely far if it is outside the picture."""
    x, y, up, radius = sphere[0] - eye[0], sphere[1] - eye[1], sphere[2] - eye[2], sphere[3]
    ahead, right = x * eye[3] + y * eye[4], x * eye[4] - y * eye[3]
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
        eye = _eye(view, bodies.poses[body])
        mesh = bodies.looks[body, 0]
        for cluster in range(geometry.meshes[mesh, 0], geometry.meshes[mesh, 1]):
            nearest = _nearest(eye, setting, geometry.spheres[cluster])
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
def _is_hidden(eye: _Eye, setting: Setting, sphere: Floats, keys: npt.NDArray[np.int64]) -> bool:
    """Whether everything where a sphere can be seen is nearer than the sphere, which is wholly ahead."""
    x, y, up, radius = sphere[0] - eye[0], sphere[1] - eye[1], sphere[2] - eye[2], sphere[3]
    ahead, right = x * eye[3] + y * eye[4], x * eye[4] - y * eye[3]
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
    texels: Integers,
    place: Integers,
    look: Integers,
    group: int,
    work: Scratch,
    number: int,
) -> None:
    """The first pass of a cluster, `whole` if all of it is ahead; its polygons have their own numbers plus `number`."""
    first, end = geometry.clusters[cluster, 0], geometry.clusters[cluster, 2]
    _project(eye, setting, geometry.points[first:end], work.points)
    for polygon in range(geometry.clusters[cluster, 1], geometry.clusters[cluster, 3]):
        plane = geometry.planes[polygon]
        over = plane[0] * eye[0] + plane[1] * eye[1] + plane[2] * eye[2] - plane[3]
        if over <= _THINNEST:
            continue
        corner, corners = geometry.shapes[polygon, 0], geometry.shapes[polygon, 1]
        outline = geometry.corners[corner : corner + corners]
        n = _outline(outline, whole, setting.near / eye[5], setting, work.points, work.outline)
        top, bottom = _rows(n, setting.size, work.outline)
        if top < bottom:
            _edges(n, top, bottom, setting.size, work.outline, work.spans)
            _fill(eye, setting, plane, over, top, bottom, work, number + polygon)
            curved = geometry.shapes[polygon, 2]
            _describe(eye, setting, plane, curved, texels, place, look, group, over, work, number + polygon)


@_inlined
def _project(eye: _Eye, setting: Setting, points: Floats, projected: Doubles) -> None:
    middle, focal = 0.5 * setting.size, setting.focal
    for i in range(len(points)):
        x, y, up = points[i, 0] - eye[0], points[i, 1] - eye[1], points[i, 2] - eye[2]
        ahead, right = x * eye[3] + y * eye[4], x * eye[4] - y * eye[3]
        by = focal / ahead
        projected[i, 0], projected[i, 1], projected[i, 2] = right, up, ahead
        projected[i, 3], projected[i, 4] = middle + right * by, middle - up * by


@_inlined
def _outline(corners: Integers, whole: bool, near: float, setting: Setting, points: Doubles, outline: Doubles) -> int:
    """The corners on the picture of what lies beyond the near plane; returns how many."""
    if whole:
        for i in range(len(corners)):
            outline[i, 0], outline[i, 1] = points[corners[i], 3], points[corners[i], 4]
        return len(corners)
    middle, by = 0.5 * setting.size, setting.focal / near
    before = corners[len(corners) - 1]
    kept = 0
    for i in range(len(corners)):
        corner = corners[i]
        seen = points[corner, 2] >= near
        if (points[before, 2] >= near) != seen:
            # From the visible end, so that neighbours cut their common edge in the same place.
            a, b = (corner, before) if seen else (before, corner)
            part = (points[a, 2] - near) / (points[a, 2] - points[b, 2])
            outline[kept, 0] = middle + by * (points[a, 0] + part * (points[b, 0] - points[a, 0]))
            outline[kept, 1] = middle - by * (points[a, 1] + part * (points[b, 1] - points[a, 1]))
            kept += 1
        if seen:
            outline[kept, 0], outline[kept, 1] = points[corner, 3], points[corner, 4]
            kept += 1
        before = corner
    return kept


@_inlined
def _centre(place: float, size: float) -> int:
    """The first pixel whose centre is not before a place on the picture, along a column or a row."""
    return math.ceil(min(max(place - 0.5, 0.0), size))


@_inlined
def _rows(n: int, size: int, outline: Doubles) -> tuple[int, int]:
    """From and to which row an outline may cover centres of pixels."""
    if n < 3:
        return 0, 0
    left = right = outline[0, 0]
    high = low = outline[0, 1]
    for i in range(1, n):
        left, right = min(left, outline[i, 0]), max(right, outline[i, 0])
        high, low = min(high, outline[i, 1]), max(low, outline[i, 1])
    limit = float(size)
    if _centre(left, limit) >= _centre(right, limit):
        return 0, 0
    return _centre(high, limit), _centre(low, limit)


@_inlined
def _edges(n: int, top: int, bottom: int, size: int, outline: Doubles, spans: Integers) -> None:
    """Fills in the columns from and to of each row."""
    limit = float(size)
    before_x, before_y = outline[n - 1, 0], outline[n - 1, 1]
    for i in range(n):
        x, y = outline[i, 0], outline[i, 1]
        # What is seen from its front lies to the right of an edge that runs down. Neighbours walk their edge downwards.
        side = 0 if y > before_y else 1
        x0, y0, x1, y1 = (before_x, before_y, x, y) if side == 0 else (x, y, before_x, before_y)
        start, end = max(_centre(y0, limit), top), min(_centre(y1, limit), bottom)
        if start < end:
            slope = (x1 - x0) / (y1 - y0)
            base = x0 + (0.5 - y0) * slope
            for row in range(start, end):
                spans[row, side] = _centre(base + row * slope, limit)
        before_x, before_y = x, y


@_inlined
def _across(eye: _Eye, setting: Setting, x: float, y: float, z: float) -> tuple[float, float, float]:
    """What a gradient in the body's frame becomes on the picture: a column, a row, and at the first pixel's centre."""
    column, row = (x * eye[4] - y * eye[3]) / setting.focal, -z / setting.focal
    return column, row, x * eye[3] + y * eye[4] - (0.5 * setting.size - 0.5) * (column + row)


@_inlined
def _fill(
    eye: _Eye, setting: Setting, plane: Floats, over: float, top: int, bottom: int, work: Scratch, number: int
) -> None:
    """Puts a polygon into the pixels where nothing is nearer."""
    keys, spans = work.keys, work.spans
    column, row, first = _across(eye, setting, plane[0], plane[1], plane[2])
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
    plane: Floats,
    curved: int,
    texels: Integers,
    place: Integers,
    look: Integers,
    group: int,
    over: float,
    work: Scratch,
    number: int,
) -> None:
    """Notes what the second pass needs to know of a polygon."""
    functions, marks = work.functions[number], work.marks[number]
    patterned = plane[12] != 0.0
    marks[0], marks[1], marks[2], marks[5] = 2 * curved + patterned, look[1], look[2], group
    if patterned:
        for i in (4, 8):
            _note(eye, setting, plane[i], plane[i + 1], plane[i + 2], plane[i + 3], functions, i - 4)
        scale = eye[5]
        functions[12] = plane[12] * place[1] * place[2] / (setting.focal * setting.focal * over * scale * scale * scale)
    else:
        marks[4] = texels[place[0] + int(plane[11] * place[2]) * place[1] + int(plane[7] * place[1])]
    cos, sin = eye[6], eye[7]
    sun_x, sun_y, sun_z = (
        setting.sun[0] * cos - setting.sun[1] * sin,
        setting.sun[0] * sin + setting.sun[1] * cos,
        setting.sun[2],
    )
    facing = sun_x * plane[16] + sun_y * plane[20] + sun_z * plane[24]
    marks[3] = _I32((setting.ambient + setting.diffuse * max(facing, 0.0)) * _FULL)
    if curved:
        x = sun_x * plane[13] + sun_y * plane[17] + sun_z * plane[21]
        y = sun_x * plane[14] + sun_y * plane[18] + sun_z * plane[22]
        z = sun_x * plane[15] + sun_y * plane[19] + sun_z * plane[23]
        _note(eye, setting, x, y, z, facing, functions, 8)


@_inlined
def _note(
    eye: _Eye, setting: Setting, x: float, y: float, z: float, constant: float, functions: Floats, first: int
) -> None:
    """Writes down a function of the position, given in the body's frame, as one of the place on the picture."""
    column, row, corner = _across(eye, setting, x, y, z)
    scale = eye[5]
    functions[first], functions[first + 1], functions[first + 2] = column / scale, row / scale, corner / scale
    functions[first + 3] = x * eye[0] + y * eye[1] + z * eye[2] + constant


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
        marks, functions = work.marks[number], work.functions[number]
        label, kind = np.uint16(marks[2]), marks[0]
        for i in range(start, x):
            labels[line + i] = label
        nearness = _I32(keys[line + start] >> _I64(32)).view(_F32)
        if kind & 1:
            texels = textures.texels if marks[5] == 0 else actor_textures.texels
            place = textures.places[marks[1]] if marks[5] == 0 else actor_textures.places[marks[1]]
            _look_up(nearness, functions, place, setting.levels, y, start, x, work.indices)
            for i in range(start, x):
                colours[i] = texels[_U64(work.indices[i])]
        else:
            colour = marks[4]
            for i in range(start, x):
                colours[i] = colour
        if kind & 2:
            _light_up(nearness, functions, setting, y, start, x, shades)
        else:
            shade = marks[3]
            for i in range(start, x):
                shades[i] = shade


@_inlined
def _look_up(
    nearness: Any, f: Floats, place: Integers, levels: int, y: int, start: Any, end: Any, indices: Integers
) -> None:
    """Finds the texels of a run; may write up to seven more to the right."""
    row = _F32(y)
    u_step, u_base, u_own = f[0], f[1] * row + f[2], f[3]
    v_step, v_base, v_own = f[4], f[5] * row + f[6], f[7]
    inside, near_step, from_column = f[12], f[13], _F32(_I32(start))
    first, width, rows = place[0], place[1], _F32(place[3])
    wide, high, last = _F32(width), _F32(place[2]), _I32(first + place[3] * width - 1)
    coarsest = _I32(min(levels, place[4]) - 1)
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
        line = _I32(_I32(rows - rows * half) + _I32(v * high * half))
        texel = _I32(_I32(first + _I32(line * width)) + _I32(u * wide * half))
        indices[x] = min(max(texel, first), last)


@_inlined
def _light_up(nearness: Any, f: Floats, setting: Setting, y: int, start: Any, end: Any, shades: Integers) -> None:
    """Finds the brightness of a run on a curved surface; may write up to seven more to the right."""
    step, base, own = f[8], f[9] * _F32(y) + f[10], f[11]
    near_step, from_column = f[13], _F32(_I32(start))
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
