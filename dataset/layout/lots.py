"""Division of a raster of built-up ground into building lots: axis-aligned, non-overlapping rectangles."""

from itertools import pairwise
from random import Random
from typing import NamedTuple

import numpy as np
from scipy import ndimage

from arramon_dataset.layout.grid import Mask


class CellRectangle(NamedTuple):
    """Cells from (top, left), inclusive, to (bottom, right), exclusive, on a mask's first and second axis."""

    top: int
    left: int
    bottom: int
    right: int

    @property
    def shape(self) -> tuple[int, int]:
        """Number of cells along the first and the second axis."""
        return self.bottom - self.top, self.right - self.left


def cover_with_rectangles(mask: Mask, shortest: int) -> list[CellRectangle]:
    """Return non-overlapping rectangles inside `mask`, those with the largest inscribed squares first.

    No square of `shortest` cells fits into what stays uncovered.
    """
    left = np.pad(mask, 1)
    rectangles: list[CellRectangle] = []
    while True:
        depth = ndimage.distance_transform_cdt(left, metric="chessboard")
        centre = int(depth.argmax())
        row, column = divmod(centre, left.shape[1])
        if depth[row, column] == 0:
            return rectangles
        reach = int(depth[row, column]) - 1
        seed = CellRectangle(row - reach, column - reach, row + reach + 1, column + reach + 1)
        best = max((grow(left, seed, order) for order in ("rows", "columns")), key=lambda r: r.shape[0] * r.shape[1])
        if min(best.shape) < shortest:
            return rectangles
        left[best.top : best.bottom, best.left : best.right] = False
        rectangles.append(CellRectangle(*(edge - 1 for edge in best)))


def grow(mask: Mask, seed: CellRectangle, first: str) -> CellRectangle:
    """Return `seed` extended inside `mask` as far as possible, rows or columns first. The mask's border is empty."""
    top, left, bottom, right = seed
    for direction in ("rows", "columns") if first == "rows" else ("columns", "rows"):
        if direction == "rows":
            while mask[top - 1, left:right].all():
                top -= 1
            while mask[bottom, left:right].all():
                bottom += 1
        else:
            while mask[top:bottom, left - 1].all():
                left -= 1
            while mask[top:bottom, right].all():
                right += 1
    return CellRectangle(top, left, bottom, right)


def split_into_lots(rectangle: CellRectangle, shortest: int, longest: int, random: Random) -> list[CellRectangle]:
    """Return the rectangle as lots with sides of `shortest` to `longest` cells, where its own sides are long enough."""
    rows = cuts(rectangle.top, rectangle.bottom, shortest, longest, random)
    columns = cuts(rectangle.left, rectangle.right, shortest, longest, random)
    return [
        CellRectangle(top, left, bottom, right) for top, bottom in pairwise(rows) for left, right in pairwise(columns)
    ]


def cuts(start: int, end: int, shortest: int, longest: int, random: Random) -> list[int]:
    """Return where to cut [start, end]: both ends, and points between with gaps of `shortest` to `longest`."""
    places = [start]
    while end - places[-1] > longest:
        rest = end - places[-1]
        # The remainder must be long enough for a lot itself.
        step = random.randint(shortest, min(longest, rest - shortest))
        places.append(places[-1] + step)
    return [*places, end]
