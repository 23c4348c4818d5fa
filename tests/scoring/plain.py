"""Plain implementations of the formulas, to compare the fast ones with."""

import math
from functools import cache

Path = tuple[tuple[float, float], ...]


def distinct(path: Path) -> Path:
    kept: list[tuple[float, float]] = []
    for point in path:
        if not kept or point != kept[-1]:
            kept.append(point)
    return tuple(kept)


def dtw(path: Path, reference: Path) -> float:
    """The textbook recursion: D(i, j) = d(i, j) + min(D(i-1, j), D(i, j-1), D(i-1, j-1))."""

    @cache
    def total(i: int, j: int) -> float:
        if i < 0 and j < 0:
            return 0.0
        if i < 0 or j < 0:
            return math.inf
        (x, z), (u, v) = path[i], reference[j]
        return math.sqrt((x - u) ** 2 + (z - v) ** 2) + min(total(i - 1, j), total(i, j - 1), total(i - 1, j - 1))

    return total(len(path) - 1, len(reference) - 1)


def ndtw(path: Path, reference: Path) -> float:
    if not path:
        return 0.0
    path, reference = distinct(path), distinct(reference)
    return math.exp(-dtw(path, reference) / (3.0 * len(reference)))
