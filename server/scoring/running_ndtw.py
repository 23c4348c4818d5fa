"""nDTW of a path that grows: its value after every position, in the time of one for the whole path."""

import math
from collections.abc import Sequence

import numpy as np

from arramon_server.scoring.metrics import NDTW_THRESHOLD
from arramon_server.scoring.trajectory import Point2


class RunningNdtw:
    """nDTW between a growing path and a reference, equal to `metrics.ndtw` of the path so far.

    Args:
        reference: positions (x, z) of the ground truth, in order.
        threshold: mean distance per reference point that scores 1/e, in units.

    Raises:
        ValueError: if the reference is empty.
    """

    def __init__(self, reference: Sequence[Point2], threshold: float = NDTW_THRESHOLD) -> None:
        if not len(reference):
            raise ValueError("the reference path is empty; expected at least one position")
        distinct = [point for before, point in zip([None, *reference], reference, strict=False) if point != before]
        self._reference = np.array(distinct, dtype=np.float64)
        self._threshold = threshold
        self._last: Point2 | None = None
        self._costs: list[float] = []
        """Least costs of warping the path so far to each prefix of the reference."""

    def add(self, point: Point2) -> None:
        """Extend the path by a position; one that is equal to the last has no effect."""
        if point == self._last:
            return
        distances = np.hypot(*(np.array(point) - self._reference).T).tolist()
        before, costs = self._costs, list[float]()
        for column, distance in enumerate(distances):
            entries = [costs[-1]] if column else []
            if before:
                entries += [before[column], before[column - 1]] if column else [before[0]]
            costs.append(distance + min(entries, default=0.0))
        self._costs, self._last = costs, point

    @property
    def value(self) -> float:
        """The nDTW of the path so far, in [0, 1]; 0 for an empty path."""
        if not self._costs:
            return 0.0
        return math.exp(-self._costs[-1] / (self._threshold * len(self._reference)))
