"""Segmentation of things on the ground by depth alone: connected pixels above the ground without jumps in depth."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from arramon_agents.perception.eyes.kernels import (
    fill_crop,
    find_walls,
    mark_solid,
    measure_parts,
    number_parts,
    number_rims,
)
from arramon_agents.perception.eyes.pixel_rays import rays
from arramon_agents.perception.eyes.reach import NEAR, Reach
from arramon_client.world import EYE_HEIGHT

MIN_HEIGHT, MAX_HEIGHT = 0.018, 2.2
"""Range of heights above the ground, in units, in which pixels are considered: above painted lines and pavements."""

WALL_TOP, WALL_BOTTOM, WALL_WIDTH = 1.25, 0.6, 0.6
"""Heights above and below which parts of a wall must be visible, and minimum width of a wall, in units."""

JUMP, RELATIVE_JUMP = 0.06, 0.03
"""Minimum jump in depth between neighbouring pixels of two things: in units, plus a share of their depth."""

MAX_THING_WIDTH = 3.0
"""Maximum width of a thing, in units; anything wider is a wall."""

BEFORE_WALL = 0.3
"""Distance before the wall of its column, in units, from which a pixel is not of the wall."""

CROP_SIZE = 32
"""Side length of a crop, in pixels."""

MARGIN = 0.12
"""Margin around a thing in its crop, as a share of the thing's larger side."""

CROP_CHANNELS = 6
"""Channels of a crop: red, green, blue, mask of the thing, height above the ground, distance behind the thing's
centre."""

MEASURES = 5
"""Number of measures of a thing, see `FrameThing.measures`."""

Floats = npt.NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class FrameThing:
    """A thing cut out of a frame.

    Attributes:
        rows, columns: bounding box, in pixels.
        mask: which pixels in the box belong to the thing.
        right, ahead: its centre in the camera's frame, in units.
        width, low, high: its width, and the heights of its lower and upper end, in units.
    """

    rows: slice
    columns: slice
    mask: npt.NDArray[np.bool_]
    right: float
    ahead: float
    width: float
    low: float
    high: float

    @cached_property
    def pixels(self) -> int:
        """Number of its pixels."""
        return int(self.mask.sum())

    @property
    def measures(self) -> tuple[float, float, float, float, float]:
        """Nearness, width, heights of lower and upper end, and logarithm of the number of pixels, scaled to about 1."""
        return 1.0 / (1.0 + self.ahead), min(self.width, 2.0), self.low, self.high, math.log(self.pixels) / 8.0


@dataclass(frozen=True, eq=False)
class FrameParts:
    """A frame cut into connected parts.

    Attributes:
        things: the things, the nearest first.
        parts: the number of the part that each of them is, from 1.
        numbers: (size, size) number of the part that each pixel belongs to; 0 for none.
        is_small: (parts + 1,) whether each part is too small to be a thing, by number.
        depth: (size, size) units.
        walls: (size,) depth of the wall in each column, 0 without any.
    """

    things: list[FrameThing]
    parts: list[int]
    numbers: npt.NDArray[np.int32]
    is_small: npt.NDArray[np.bool_]
    depth: Floats
    walls: Floats

    def rims(self) -> npt.NDArray[np.int32]:
        """Return (size, size) the number of the part whose rim each pixel is; 0 for pixels that are no rim.

        A rim lies beside a part and before the walls, but behind a jump in depth, and so is of no part.
        """
        rims = np.empty_like(self.numbers)
        number_rims(self.depth, self.walls, self.numbers, BEFORE_WALL, rims)
        return rims


def find_things(depth: Floats, reach: Reach = NEAR) -> list[FrameThing]:
    """Return the things in a frame, the nearest first; arguments as for `find_parts`."""
    return find_parts(depth, reach).things


def find_parts(depth: Floats, reach: Reach = NEAR) -> FrameParts:
    """Cut a frame into parts.

    Args:
        depth: (size, size) units along the viewing direction, 0 where there is nothing.
        reach: which things are cut out.
    """
    size = len(depth)
    down = right = rays(size)
    walls, marked = np.empty(size, np.float32), np.empty((size, size), np.bool_)
    find_walls(depth, down, EYE_HEIGHT, WALL_TOP, WALL_BOTTOM, WALL_WIDTH, walls)
    mark_solid(depth, walls, down, EYE_HEIGHT, MIN_HEIGHT, MAX_HEIGHT, reach.ahead, JUMP, RELATIVE_JUMP, marked)
    numbers = np.empty((size, size), np.int32)
    count = number_parts(marked, numbers)
    boxes, pixels = np.empty((count, 4), np.int64), np.zeros(count, np.int64)
    spans = np.empty((count, 4), np.float32)
    measure_parts(numbers, depth, right, EYE_HEIGHT, boxes, pixels, spans)
    first, last, low, high = spans.T
    widths, middles = last - first, (first + last) / 2
    found = []
    for part in np.flatnonzero((pixels >= reach.pixels) & (widths <= MAX_THING_WIDTH)):
        rows, columns = slice(*boxes[part, ::2].tolist()), slice(*boxes[part, 1::2].tolist())
        mask = numbers[rows, columns] == part + 1
        ahead = float(depth[rows, columns][mask].mean())
        width, lowest, highest = float(widths[part]), float(low[part]), float(high[part])
        thing = FrameThing(rows, columns, mask, float(middles[part]), ahead, width, lowest, highest)
        found.append((thing, int(part) + 1))
    found.sort(key=lambda each: each[0].ahead)
    things, parts = [thing for thing, _ in found], [part for _, part in found]
    return FrameParts(things, parts, numbers, np.append(False, pixels < reach.pixels), depth, walls)


def crop(rgb: npt.NDArray[np.uint8], depth: Floats, thing: FrameThing) -> Floats:
    """Return the crop of a thing with a margin, scaled to 32x32 pixels, (32, 32, 6), values about 0 to 1.

    Args:
        rgb: (size, size, 3) uint8.
        depth: (size, size) units.
        thing: a thing of this frame.
    """
    height, width = thing.mask.shape
    half = (0.5 + MARGIN) * max(height, width)
    steps = (np.arange(CROP_SIZE) + 0.5) / CROP_SIZE * 2 * half - half
    rows = np.floor(thing.rows.start + height / 2 + steps).astype(np.int64)
    columns = np.floor(thing.columns.start + width / 2 + steps).astype(np.int64)
    found = np.zeros((CROP_SIZE, CROP_SIZE, CROP_CHANNELS), np.float32)
    first = thing.rows.start, thing.columns.start
    fill_crop(rgb, depth, rows, columns, thing.mask, first, rays(len(depth)), EYE_HEIGHT, thing.ahead, found)
    return found
