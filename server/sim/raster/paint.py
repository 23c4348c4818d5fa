"""The rasteriser's second pass, compiled: computes colour, depth and label of every pixel once.

A row is painted in runs of one polygon, from the first pass's data. Loops over pixels are written for the compiler's
vectoriser: in 32 bits, without branches, with few arrays each. The arithmetic is deterministic here too.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

from arramon_server.sim.cameras import THOUSANDTH
from arramon_server.sim.raster.arrays import FrameConstants, Integers, Scratch, Textures
from arramon_server.sim.raster.compilation import cached, inlined

_I32, _I64, _U64, _F32 = np.int32, np.int64, np.uint64, np.float32

_FULL = 4096
"""Brightness that does not change a colour."""

_THOUSANDTH = float(THOUSANDTH)

_BAND = 4
"""Rows that are packed at once: a multiple of four pixels in every size, and few enough for the nearest cache."""


@cached
def paint(
    setting: FrameConstants,
    textures: Textures,
    actor_textures: Textures,
    sky: Integers,
    work: Scratch,
    rgb: Integers,
    depth: npt.NDArray[np.uint16],
    units: npt.NDArray[np.float32],
    labels: npt.NDArray[np.uint16],
) -> None:
    """Compute the frame from the first pass's data in `work`. Whatever has an empty array is left out.

    Args:
        setting: constants of the frame.
        textures: textures of the bodies.
        actor_textures: textures of the actors.
        sky: (size * size,) 0xBBGGRR, the background.
        work: buffers from the first pass; the row buffers are overwritten.
        rgb: output, (size * size * 3 / 4, rounded up,): three bytes per pixel; or empty.
        depth: output, (size * size,), in thousandths as in `cameras.Frame`, or empty.
        units: output, (size * size,), the same in units, or empty.
        labels: output, (size * size,), or empty.
    """
    size = setting.size
    for band in range(0, size, _BAND):
        for y in range(band, min(band + _BAND, size)):
            if len(rgb):
                _paint_row(y, setting, textures, actor_textures, sky, work, labels)
            else:
                _label_row(y * size, size, work, labels)
            if len(depth):
                _measure_row(y * size, size, work.keys, depth)
            if len(units):
                _measure_row_in_units(y * size, size, work.keys, units)
            if len(rgb):
                _light_row((y - band) * size, size, work.colours, work.shades, work.lit)
        if len(rgb):
            _pack(band * size, min(_BAND, size - band) * size, work.lit, rgb)


@inlined
def _label_row(first: int, size: int, work: Scratch, labels: Any) -> None:
    """Write the labels of a row, without colours."""
    for i in range(first, first + size if len(labels) else first):
        number = _I32(work.keys[i])
        labels[i] = np.uint16(work.marks[number, 2] if number != 0 else 0)


@inlined
def _paint_row(
    y: int,
    setting: FrameConstants,
    textures: Textures,
    actor_textures: Textures,
    sky: Integers,
    work: Scratch,
    labels: Any,
) -> None:
    """Compute colours, brightness and labels of a row, in runs of one polygon."""
    keys, colours, shades = work.keys, work.colours, work.shades
    line, end = _U64(y * setting.size), _U64(setting.size)
    x = _U64(0)
    while x < end:
        number = _I32(keys[line + x])
        start = x
        while x < end and _I32(keys[line + x]) == number:
            x += _U64(1)
        if len(labels):
            label = np.uint16(work.marks[number, 2] if number != 0 else 0)
            for i in range(start, x):
                labels[line + i] = label
        if number == 0:
            for i in range(start, x):
                colours[i], shades[i] = sky[line + i], _I32(_FULL)
            continue
        kind, texture = work.marks[number, 0], work.marks[number, 1]
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


@inlined
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
    """Look up the texels of a run; may write up to seven more indices to the right."""
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
        # The level whose texels are about as large as a pixel: the rounded logarithm, base 4, of texels per pixel.
        texels = _F32(inside * distance * distance * distance)
        level = _I32(_I32(texels.view(_I32) >> _I32(23)) - _I32(126)) >> _I32(1)
        level = min(max(_I32(level), _I32(0)), coarsest)
        half = _I32(_I32(_I32(127) - level) << _I32(23)).view(_F32)  # 0.5 to the power of the level
        line = _I32(_I32(long - long * half) + _I32(v * high * half))
        texel = _I32(_I32(first + _I32(line * width)) + _I32(u * wide * half))
        indices[x] = min(max(texel, first), last)
    for x in range(start, end):
        colours[x] = textures.texels[_U64(indices[x])]


@inlined
def _light_run(
    nearness: Any, number: Any, setting: FrameConstants, y: int, start: Any, end: Any, work: Scratch
) -> None:
    """Compute the brightness of a run on a curved surface; may write up to seven more values to the right."""
    f, shades = work.functions, work.shades
    step, base, own = f[number, 8], f[number, 9] * _F32(y) + f[number, 10], f[number, 11]
    near_step, from_column = f[number, 13], _F32(_I32(start))
    ambient, diffuse = _F32(setting.ambient * _FULL), _F32(setting.diffuse * _FULL)
    for x in range(start, start + ((end - start + _U64(7)) & ~_U64(7))):
        column = _F32(_I32(x))
        distance = _F32(1.0) / (nearness + near_step * (column - from_column))
        facing = own + distance * (base + step * column)
        shades[x] = _I32(ambient + diffuse * max(facing, _F32(0.0)))


@inlined
def _thousandths(key: Any) -> Any:
    nearness = _I32(key >> _I64(32)).view(_F32)
    thousandths = _I32(min(_F32(1000.0) / nearness + _F32(0.5), _F32(65535.0)))
    return thousandths if _I32(key) != 0 else _I32(0)


@inlined
def _measure_row(first: int, size: int, keys: npt.NDArray[np.int64], depth: npt.NDArray[np.uint16]) -> None:
    for i in range(_U64(first), _U64(first + size)):
        depth[i] = np.uint16(_thousandths(keys[i]))


@inlined
def _measure_row_in_units(first: int, size: int, keys: npt.NDArray[np.int64], units: npt.NDArray[np.float32]) -> None:
    for i in range(_U64(first), _U64(first + size)):
        units[i] = _F32(_thousandths(keys[i])) * _F32(_THOUSANDTH)


@inlined
def _light_row(first: int, size: int, colours: Integers, shades: Integers, lit: Integers) -> None:
    line, byte = _U64(first), _I32(255)
    for i in range(_U64(size)):
        colour, shade = colours[i], shades[i]
        red = min(_I32(_I32(colour & byte) * shade) >> _I32(12), byte)
        green = min(_I32(_I32((colour >> _I32(8)) & byte) * shade) >> _I32(12), byte)
        blue = min(_I32(_I32(colour >> _I32(16)) * shade) >> _I32(12), byte)
        lit[line + i] = red | (green << _I32(8)) | (blue << _I32(16))


@inlined
def _pack(first: int, pixels: int, lit: Integers, rgb: Integers) -> None:
    """Pack pixels: four pixels of four bytes each, one of them unused, become three words.

    The pixels begin at a multiple of four; what is missing of the last four is packed as it is.
    """
    word = _U64(first // 4 * 3)
    for i in range(_U64((pixels + 3) // 4)):
        four, three = _U64(4) * i, word + _U64(3) * i
        a, b, c, d = lit[four], lit[four + _U64(1)], lit[four + _U64(2)], lit[four + _U64(3)]
        rgb[three] = a | _I32(b << _I32(24))
        rgb[three + _U64(1)] = (b >> _I32(8)) | _I32(c << _I32(16))
        rgb[three + _U64(2)] = (c >> _I32(16)) | _I32(d << _I32(8))
