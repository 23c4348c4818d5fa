"""The paper's metrics (section 4), each a pure function of numbers. Distances are in units, which read as metres."""

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from server.scoring.trajectory import Cell, Point2, Point3

NDTW_THRESHOLD = 3.0
"""Units per reference point at which nDTW has fallen to 1/e."""


def ndtw(path: Sequence[Point2], reference: Sequence[Point2], threshold: float = NDTW_THRESHOLD) -> float:
    """Normalised dynamic time warping: exp(-DTW(path, reference) / (threshold * |reference|)).

    Both paths are first reduced to their distinct consecutive positions: turns and blocked moves add nothing.

    Args:
        path: the agent's positions (x, z), in order; one that is empty scores 0.
        reference: the ground truth's positions (x, z), in order.
        threshold: in units.

    Returns:
        A score in [0, 1]; 1 for the same path.

    Raises:
        ValueError: for an empty reference, or paths that are not rows of (x, z).
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
    """CTC-k for k > 0: whether the agent ended strictly nearer than `k` to the target, in three dimensions."""
    return final is not None and math.dist(final, target) < k


def placement_distance(placed: Cell, target: Cell) -> int:
    """The Manhattan distance D between two places in the room, in cells and levels."""
    return sum(abs(a - b) for a, b in zip(placed, target, strict=True))


def rpod(distance: float) -> float:
    """Reciprocal placed object distance: 1 / (1 + D^2)."""
    return 1.0 / (1.0 + distance * distance)


def ptc(distance: float) -> float:
    """Placed target correctness: 1 where D is 0, otherwise 0."""
    return float(distance == 0)


def _distinct(path: Sequence[Point2]) -> npt.NDArray[np.float64]:
    """The path without consecutive repetitions, (n, 2)."""
    points = np.asarray(path, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 2:
        raise ValueError(f"a path of shape {points.shape}; expected rows of (x, z)")
    moved = np.ones(len(points), dtype=bool)
    moved[1:] = (points[1:] != points[:-1]).any(axis=1)
    return points[moved]


def _dtw(cost: npt.NDArray[np.float64]) -> float:
    """The least sum of `cost` (n, m) along a warping path from its first cell to its last.

    Cells of one anti-diagonal depend on the two before it alone, so each is computed at once: the very additions and
    minima of the usual double loop, in an order that numpy can do quickly.
    """
    n, m = cost.shape
    diagonals = np.full((n + m - 1, n), np.inf)  # diagonals[i + j, i] = cost[i, j]; what lies outside stays infinite
    rows, columns = np.indices(cost.shape)
    diagonals[rows + columns, rows] = cost
    # Row i is kept at index i + 1; index 0 stands before the first row and is the way in for the first diagonal alone.
    before, last = np.full(n + 1, np.inf), np.full(n + 1, np.inf)
    before[0] = 0.0
    for diagonal in diagonals:
        current = np.full(n + 1, np.inf)
        current[1:] = diagonal + np.minimum(np.minimum(last[1:], last[:-1]), before[:-1])
        before, last = last, current
    return float(last[n])
