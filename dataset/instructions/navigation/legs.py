"""Simplification of a path to straight legs."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from arramon_client.world import bearing, turn_between

Place = tuple[float, float]
"""(x, z), in units."""

TOLERANCE = 1.2
"""Maximum distance of a path from its legs, in units."""

STRAIGHT = 20.0
"""Consecutive legs that differ by less than this many degrees are merged."""


@dataclass(frozen=True, slots=True)
class Leg:
    """A straight segment of a path.

    Attributes:
        start, end: positions of its ends.
        first, last: indices of these positions in the path.
        heading: degrees clockwise from +z.
        length: in units.
    """

    start: Place
    end: Place
    first: int
    last: int
    heading: float
    length: float

    def local(self, x: float, z: float) -> tuple[float, float]:
        """Return a place relative to the leg's start: (units to the right, units along the leg)."""
        angle = math.radians(self.heading)
        dx, dz, sin, cos = x - self.start[0], z - self.start[1], math.sin(angle), math.cos(angle)
        return dx * cos - dz * sin, dx * sin + dz * cos


def legs_of(path: Sequence[Place]) -> list[Leg]:
    """Return the legs of a path; none if it does not move."""
    corners = _corners(path, 0, len(path) - 1)
    changed = True
    while changed:
        changed = False
        for before, at, after in zip(corners, corners[1:], corners[2:], strict=False):
            if abs(turn_between(bearing(path[before], path[at]), bearing(path[at], path[after]))) < STRAIGHT:
                corners.remove(at)
                changed = True
                break
    return [
        Leg(path[a], path[b], a, b, bearing(path[a], path[b]), math.dist(path[a], path[b]))
        for a, b in pairwise(corners)
        if path[a] != path[b]
    ]


def max_deviation(path: Sequence[Place], first: int, last: int, start: Place, end: Place) -> float:
    """Return the maximum distance of a path's places `first` to `last` from the segment from start to end, in units."""
    return max(_from_segment(place, start, end) for place in path[first : last + 1])


def _corners(path: Sequence[Place], first: int, last: int) -> list[int]:
    """Return the indices of the places to which the path can be reduced (Douglas and Peucker)."""
    farthest, far = first, 0.0
    for i in range(first + 1, last):
        distance = _from_segment(path[i], path[first], path[last])
        if distance > far:
            farthest, far = i, distance
    if far <= TOLERANCE:
        return [first, last]
    return _corners(path, first, farthest)[:-1] + _corners(path, farthest, last)


def _from_segment(p: Place, a: Place, b: Place) -> float:
    dx, dz = b[0] - a[0], b[1] - a[1]
    square = dx * dx + dz * dz
    share = 0.0 if square == 0.0 else min(max(((p[0] - a[0]) * dx + (p[1] - a[1]) * dz) / square, 0.0), 1.0)
    return math.hypot(p[0] - a[0] - share * dx, p[1] - a[1] - share * dz)
