"""Metrics of the paper (section 4) as pure functions. Distances are in units of the simulator, taken as metres."""

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from arramon_server.scoring.trajectory import Cell, Point2, Point3

NDTW_THRESHOLD = 3.0
"""Mean distance per reference point at which nDTW is 1/e, in units."""


def ndtw(path: Sequence[Point2], reference: Sequence[Point2], threshold: float = NDTW_THRESHOLD) -> float:
    """Return the normalised dynamic time warping, exp(-DTW(path, reference) / (threshold * |reference|)).

    Both paths are first reduced to their distinct consecutive positions: turns and blocked moves do not count.

    Args:
        path: positions (x, z) of the agent, in order; an empty path scores 0.
        reference: positions (x, z) of the ground truth, in order.
        threshold: mean distance per reference point that scores 1/e, in units.

    Returns:
        A score in [0, 1]; 1 for equal paths.

    Raises:
        ValueError: if the reference is empty, or a path does not consist of rows (x, z).
    """
    if not len(reference):
        raise ValueError("the reference path is empty; expected at least one position")
    if not len(path):
        return 0.0
    played, truth = _distinct(path), _distinct(reference)
    difference = played[:, None, :] - truth[None, :, :]
    cost = _dtw(np.hypot(difference[..., 0], difference[..., 1]))
    return math.exp(-cost / (threshold * len(truth)))


def ctc_within(final: Point3 | None, target: Point3, k: float) -> bool:
    """Return CTC-k for k > 0: whether the agent ended strictly nearer than `k` to the target, in three dimensions."""
    return final is not None and math.dist(final, target) < k


def placement_distance(placed: Cell, target: Cell) -> int:
    """Return the Manhattan distance D between two cells of the room, in columns, levels and rows."""
    return sum(abs(a - b) for a, b in zip(placed, target, strict=True))


def rpod(distance: float) -> float:
    """Return the reciprocal placed object distance, 1 / (1 + D^2)."""
    return 1.0 / (1.0 + distance * distance)


def ptc(distance: float) -> float:
    """Return the placed target correctness: 1 if D is 0, otherwise 0."""
    return float(distance == 0)


def _distinct(path: Sequence[Point2]) -> npt.NDArray[np.float64]:
    """Return the path without consecutive duplicates, (n, 2)."""
    points = np.asarray(path, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 2:
        raise ValueError(f"a path has the shape {points.shape}; expected rows of (x, z)")
    moved = np.ones(len(points), dtype=bool)
    moved[1:] = (points[1:] != points[:-1]).any(axis=1)
    return points[moved]


def _dtw(cost: npt.NDArray[np.float64]) -> float:
    """Return the least sum of `cost` (n, m) along a warping path from its first cell to its last.

    Cells of an anti-diagonal depend only on the two diagonals before it, so each diagonal is computed at once: the
    same additions and minima as in the usual double loop, in an order that numpy computes quickly.
    """
    n, m = cost.shape
    diagonals = np.full((n + m - 1, n), np.inf)  # diagonals[i + j, i] = cost[i, j]; cells outside stay infinite
    rows, columns = np.indices(cost.shape)
    diagonals[rows + columns, rows] = cost
    # Row i is at index i + 1; index 0 is before the first row, and is the entry for the first diagonal only.
    before, last = np.full(n + 1, np.inf), np.full(n + 1, np.inf)
    before[0] = 0.0
    for diagonal in diagonals:
        current = np.full(n + 1, np.inf)
        current[1:] = diagonal + np.minimum(np.minimum(last[1:], last[:-1]), before[:-1])
        before, last = last, current
    return float(last[n])
