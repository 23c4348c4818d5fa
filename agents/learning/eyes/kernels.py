"""Compiled loops over the pixels of frames: the network's input, and the pixels of things on the ground."""

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba
import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float32]

_F = TypeVar("_F", bound=Callable[..., Any])


def _compiled(function: _F) -> _F:
    """Return the function, compiled when it is first called, and kept on disk."""
    return cast(_F, numba.njit(cache=True, nogil=True)(function))


@_compiled
def fill_input(
    rgb: npt.NDArray[np.uint8], depth: Floats, down: Floats, eye: float, low: float, high: float, out: Floats
) -> None:
    """Write the network's input of a frame: colours, nearness, and height above the ground on two scales.

    Args:
        rgb: (size, size, 3).
        depth: (size, size) units, 0 where there is nothing.
        down: (size,) how far the rays of each row go down, per unit ahead.
        eye: height of the camera, in units.
        low, high: heights at which the scales end, in units.
        out: (size, size, 6).
    """
    for i in range(depth.shape[0]):
        for j in range(depth.shape[1]):
            for k in range(3):
                out[i, j, k] = rgb[i, j, k] * np.float32(1.0 / 255.0) - np.float32(0.5)
            z = depth[i, j]
            height = high
            out[i, j, 3] = 0.0
            if z > 0.0:
                height = eye - down[i] * z
                out[i, j, 3] = 2.0 / (1.0 + z)
            out[i, j, 4] = min(max(height, 0.0), low) / low
            out[i, j, 5] = min(max(height, 0.0), high) / high


@_compiled
def mark_solid(
    depth: Floats,
    down: Floats,
    eye: float,
    lowest: float,
    highest: float,
    farthest: float,
    jump: float,
    relative: float,
    out: npt.NDArray[np.bool_],
) -> None:
    """Mark the pixels of things on the ground, but for those behind a jump in depth, which keep things apart.

    Args:
        depth: (rows, size) units, 0 where there is nothing.
        down: (rows,) how far the rays of each row go down, per unit ahead.
        eye: height of the camera, in units.
        lowest, highest: heights of things above the ground, in units.
        farthest: distance ahead up to which they are marked, in units.
        jump, relative: least jump in units, and in addition as a share of the lesser depth.
        out: (rows, size), written.
    """
    rows, columns = depth.shape
    for i in range(rows):
        for j in range(columns):
            z = depth[i, j]
            height = eye - down[i] * z
            solid = z > 0.0 and z < farthest and height > lowest and height < highest
            if solid:
                for di, dj in ((-1, 0), (1, 0), (0, -1), (0, 1)):
                    y, x = i + di, j + dj
                    if y >= 0 and y < rows and x >= 0 and x < columns:
                        near = depth[y, x]
                        if near > 0.0 and z - near > jump + relative * near:
                            solid = False
            out[i, j] = solid


@_compiled
def fill_crop(
    rgb: npt.NDArray[np.uint8],
    depth: Floats,
    rows: npt.NDArray[np.int64],
    columns: npt.NDArray[np.int64],
    mask: npt.NDArray[np.bool_],
    first: tuple[int, int],
    down: Floats,
    eye: float,
    ahead: float,
    out: Floats,
) -> None:
    """Write the crop of a thing: colours, its mask, height above the ground, and distance behind its middle.

    Args:
        rgb: (size, size, 3).
        depth: (size, size) units.
        rows, columns: (n,) of the frame, for each row and column of the crop; those outside the frame are left dark.
        mask: which pixels of the thing's box are its own.
        first: first row and column of the box.
        down: (size,) how far the rays of each row go down, per unit ahead.
        eye: height of the camera, in units.
        ahead: of the thing's middle, in units.
        out: (n, n, 6), zeros.
    """
    size = depth.shape[0]
    for i in range(len(rows)):
        row = rows[i]
        if row < 0 or row >= size:
            continue
        for j in range(len(columns)):
            column = columns[j]
            if column < 0 or column >= size:
                continue
            for k in range(3):
                out[i, j, k] = rgb[row, column, k] * np.float32(1.0 / 255.0)
            y, x = row - first[0], column - first[1]
            if y >= 0 and y < mask.shape[0] and x >= 0 and x < mask.shape[1] and mask[y, x]:
                out[i, j, 3] = 1.0
            z = depth[row, column]
            out[i, j, 4] = min(max(eye - down[row] * z, 0.0), 1.0)
            out[i, j, 5] = min(max((z - ahead) * 2.0, -1.0), 1.0)
