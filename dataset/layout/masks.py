"""Raster masks of streets and built-up ground, and setbacks of building lots from the street."""

from collections.abc import Sequence
from random import Random

import numpy as np
from scipy import ndimage

from arramon_dataset.layout.grid import CELL, Mask
from arramon_dataset.layout.lots import CellRectangle

RING = 8.0
"""Width of the built-up ground around the free ground, in units, so that every street ends at a facade."""

SHORTEST, LONGEST = 4.5, 9.0
"""Range of a lot's side lengths, in units, where the ground is wide enough."""

SETBACKS = (0.0, 0.0, 0.0, 0.75, 1.0, 1.5)
"""Possible distances of a facade from the edge of the street, in units: leaves space for street furniture."""


def dilate(mask: Mask, units: float) -> Mask:
    """Return the mask of cells at most `units` from a cell in `mask`, along either axis."""
    size = 2 * round(units / CELL) + 1
    near: Mask = ndimage.maximum_filter(mask, size=size, mode="constant", cval=False)
    return near


def rectangle_mask(shape: tuple[int, ...], rectangles: Sequence[CellRectangle]) -> Mask:
    """Return the mask of all cells in any of `rectangles`."""
    mask = np.zeros(shape, dtype=bool)
    for top, left, bottom, right in rectangles:
        mask[top:bottom, left:right] = True
    return mask


def connected_to(empty: Mask, street: Mask) -> Mask:
    """Return the part of `empty` that is connected to the street."""
    labels, _ = ndimage.label(empty)
    found: Mask = np.isin(labels, np.unique(labels[street & empty]))
    return found


def with_neighbours(lot: CellRectangle) -> tuple[slice, slice]:
    """Return the slices of a lot and the cells adjacent to it."""
    top, left, bottom, right = lot
    return slice(max(top - 1, 0), bottom + 1), slice(max(left - 1, 0), right + 1)


def set_back(
    lot: CellRectangle, seen: Mask, unseen: Mask, random: Random, depths: Sequence[float] = SETBACKS
) -> CellRectangle:
    """Return the lot without a strip along some of the sides that face a street over their whole length.

    No strip is removed that would expose `unseen` cells behind the lots. `depths` of strips are in units.
    """
    smaller, seen = lot, np.pad(seen, 1)  # A lot may lie at the raster's edge.
    for side in range(4):
        depth = round(random.choice(depths) / CELL)
        top, left, bottom, right = smaller
        strip, edge, rest = (
            (CellRectangle(top, left, top + depth, right), seen[top, left + 1 : right + 1], top + depth),
            (CellRectangle(top, left, bottom, left + depth), seen[top + 1 : bottom + 1, left], left + depth),
            (
                CellRectangle(bottom - depth, left, bottom, right),
                seen[bottom + 1, left + 1 : right + 1],
                bottom - depth,
            ),
            (CellRectangle(top, right - depth, bottom, right), seen[top + 1 : bottom + 1, right + 1], right - depth),
        )[side]
        wide_enough = smaller.shape[side % 2] - depth >= round(SHORTEST / 2 / CELL)
        if edge.all() and wide_enough and not unseen[with_neighbours(strip)].any():
            smaller = smaller._replace(**{CellRectangle._fields[side]: rest})
    return smaller
