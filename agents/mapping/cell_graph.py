"""The graph of neighbouring cells of a raster, on which cheapest ways are found."""

import math

import numpy as np
import numpy.typing as npt
from scipy.sparse import csr_array

MOVES = ((1, 0), (0, 1), (1, 1), (1, -1), (2, 1), (2, -1), (1, 2), (1, -2))
"""Half of the sixteen directions between cells; the others are their opposites."""


def cell_graph(is_open: npt.NDArray[np.bool_], cost: npt.NDArray[np.floating], cell_size: float) -> csr_array:
    """Return the graph whose edges connect open cells in sixteen directions, each edge once (for `directed=False`).

    Args:
        is_open: (rows, columns) whether each cell can be entered.
        cost: (rows, columns) cost of a unit of distance in each cell; its type is that of the edges.
        cell_size: side of a cell, in units.

    Returns:
        (rows * columns, rows * columns) lengths of the edges, in units times the mean cost of both cells. Cells are
        numbered row by row.
    """
    rows, columns = is_open.shape
    number = np.arange(rows * columns).reshape(rows, columns)
    starts, ends, lengths = [], [], []
    for down, along in MOVES:
        here = slice(0, rows - down), slice(max(-along, 0), columns - max(along, 0))
        there = slice(down, rows), slice(max(along, 0), columns - max(-along, 0))
        usable = is_open[here] & is_open[there]
        starts.append(number[here][usable])
        ends.append(number[there][usable])
        lengths.append(math.hypot(down, along) * cell_size * ((cost[here] + cost[there])[usable] / 2))
    entries = np.concatenate(lengths), (np.concatenate(starts), np.concatenate(ends))
    return csr_array(entries, shape=(rows * columns, rows * columns))
