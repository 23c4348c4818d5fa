"""The surface of a plan's streets and squares: rectangles and polygons in the world frame."""

import math
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from arramon_dataset.layout.grid import Mask, Points
from arramon_dataset.plans.plan import Plan, Street

PARALLEL = 4.0
"""Maximum angle between streets that are treated as parallel or perpendicular, in degrees: their buildings share one
heading."""


@dataclass(frozen=True, slots=True)
class Strip:
    """A straight segment of street, or with zero width an edge of a square.

    Attributes:
        start, end: (x, z) of the ends of its middle line.
        half_width: in units.
        heading: of the buildings that face it, degrees clockwise from +z, modulo 90.
    """

    start: tuple[float, float]
    end: tuple[float, float]
    half_width: float
    heading: float

    def distance(self, points: Points) -> Points:
        """Return the distance of points (n, 2) from the strip, in units, (n,); 0 inside."""
        (x0, z0), (x1, z1) = self.start, self.end
        length = math.hypot(x1 - x0, z1 - z0)
        ahead_x, ahead_z = (x1 - x0) / length, (z1 - z0) / length
        dx, dz = points[:, 0] - x0, points[:, 1] - z0
        along = dx * ahead_x + dz * ahead_z
        across = np.abs(dx * ahead_z - dz * ahead_x) - self.half_width
        beyond = np.abs(along - length / 2) - length / 2
        # Rounded, so that points on the edge are on it on every machine.
        distance: Points = np.hypot(np.maximum(across.round(6), 0.0), np.maximum(beyond.round(6), 0.0))
        return distance


@dataclass(frozen=True, slots=True)
class StreetSurface:
    """The ground of all streets and squares of a plan.

    Attributes:
        strips: segments of the streets, and edges of the squares.
        squares: (n, 2) corners of each square, (x, z).
    """

    strips: tuple[Strip, ...]
    squares: tuple[Points, ...]

    @property
    def headings(self) -> tuple[float, ...]:
        """The distinct headings of all buildings, sorted."""
        return tuple(sorted({strip.heading for strip in self.strips}))

    def covers(self, points: Points) -> Mask:
        """Return which of the points (n, 2) of (x, z) are on streets or squares, (n,)."""
        covered = np.zeros(len(points), dtype=bool)
        for strip in self.strips:
            if strip.half_width:
                covered |= strip.distance(points) == 0.0
        for corners in self.squares:
            covered |= inside(corners, points)
        return covered

    def nearest_distance(self, points: Points, heading: float) -> Points:
        """Return the distance of points from the nearest strip with this heading, in units, (n,)."""
        strips = [strip for strip in self.strips if strip.heading == heading]
        distance: Points = np.min([strip.distance(points) for strip in strips], axis=0)
        return distance

    def corners(self) -> Points:
        """Return extreme points (x, z) of the surface, (n, 2): corners of squares, and ends of streets widened."""
        found = list(self.squares)
        for strip in self.strips:
            ends = np.array([strip.start, strip.end])
            found += [ends - strip.half_width, ends + strip.half_width]
        return np.concatenate(found)


def street_surface(plan: Plan) -> StreetSurface:
    """Return the ground that the plan's streets and squares cover."""
    strips: list[Strip] = []
    for street in plan.streets:
        strips += _stretches(plan, street)
    squares = tuple(plan.world(np.array(square.corners)) for square in plan.squares)
    for corners in squares:
        loop = [*corners.tolist(), corners[0].tolist()]
        strips += [_strip(start, end, 0.0) for start, end in pairwise(loop)]
    return StreetSurface(_align(strips), squares)


def _align(strips: list[Strip]) -> tuple[Strip, ...]:
    """Return the strips with one shared heading for all that are nearly parallel: that of the longest."""
    headings: list[float] = []
    for strip in sorted(strips, key=lambda strip: -math.dist(strip.start, strip.end)):
        if all(_angle_between(strip.heading, heading) > PARALLEL for heading in headings):
            headings.append(strip.heading)
    return tuple(
        replace(strip, heading=min(headings, key=lambda heading: _angle_between(strip.heading, heading)))
        for strip in strips
    )


def _angle_between(one: float, other: float) -> float:
    """Return the angle between two lines or their perpendiculars, in degrees from 0 to 45."""
    return abs((one - other + 45.0) % 90.0 - 45.0)


def inside(corners: Points, points: Points) -> Mask:
    """Return which of the points (n, 2) are in the polygon of `corners` (m, 2), (n,)."""
    x, z = points.T
    within = np.zeros(len(points), dtype=bool)
    for (x0, z0), (x1, z1) in pairwise([*corners.tolist(), corners[0].tolist()]):
        if z0 != z1:  # A ray towards +x may cross this side.
            within ^= ((z0 > z) != (z1 > z)) & (x < (x1 - x0) * (z - z0) / (z1 - z0) + x0)
    return within


def _stretches(plan: Plan, street: Street) -> list[Strip]:
    """Return the street's straight segments, extended at bends so that the outer corners are covered."""
    points = plan.world(np.array(street.points)).tolist()
    half = street.width / 2
    longer = [0.0, *(half * math.tan(_bend(*points[i - 1 : i + 2]) / 2) for i in range(1, len(points) - 1)), 0.0]
    found = []
    for (start, end), (before, after) in zip(pairwise(points), pairwise(longer), strict=True):
        length = math.dist(start, end)
        step = [(b - a) / length for a, b in zip(start, end, strict=True)]
        first = [a - before * s for a, s in zip(start, step, strict=True)]
        last = [b + after * s for b, s in zip(end, step, strict=True)]
        found.append(_strip(first, last, half))
    return found


def _bend(before: list[float], corner: list[float], after: list[float]) -> float:
    """Return the angle by which a line bends at a corner, in radians, at most a right angle."""
    first = math.atan2(corner[0] - before[0], corner[1] - before[1])
    second = math.atan2(after[0] - corner[0], after[1] - corner[1])
    turn = abs((second - first + math.pi) % (2 * math.pi) - math.pi)
    return min(turn, math.pi / 2)


def _strip(start: list[float], end: list[float], half_width: float) -> Strip:
    heading = round(math.degrees(math.atan2(end[0] - start[0], end[1] - start[1])) % 90.0, 1) % 90.0
    return Strip((start[0], start[1]), (end[0], end[1]), half_width, heading)
