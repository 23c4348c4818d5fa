"""Facts about a path: its legs, directions and bends, and where it is nearest to a place.

Planner, gate and facts for writers measure paths with these functions and judge by `path_tolerances`.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

from arramon_client.world import bearing, turn_between
from arramon_server.sim.geometry import Pose

Place = tuple[float, float]
"""(x, z), in units."""

STRIDE = 3
"""Number of places over which a direction is measured: paths zigzag by single turns of 30 degrees."""

LEG_TOLERANCE = 1.2
"""Maximum distance of a path from its legs, in units."""

LEG_STRAIGHT = 20.0
"""Consecutive legs that differ by less than this many degrees are merged."""

BEND = 8.0
"""Minimum change of direction at a bend, in degrees."""

PEAK = 2
"""Number of places on each side of a bend's sharpest place that belong to it."""

WIDE_GAP, WIDE_STRIDE = 3, 5
"""Number of places on each side of the middle that a wide bend skips, and number of places beyond them over which its
directions are measured."""


def direction(start: Place, end: Place) -> float:
    """Return the heading from one place to another, in degrees in (-180, 180].

    `arramon_client.world.bearing` returns it in [0, 360). Its last digits differ, which decides for turns that are
    exactly at a limit.
    """
    return math.degrees(math.atan2(end[0] - start[0], end[1] - start[1]))


def nearest_on_segment(place: Place, start: Place, end: Place) -> Place:
    """Return the point of a segment nearest to a place."""
    share = _nearest_share(place, start, end)
    return start[0] + share * (end[0] - start[0]), start[1] + share * (end[1] - start[1])


def nearest_on_outline(outline: Sequence[Place], place: Place) -> Place:
    """Return the point of a closed outline, at least one corner, nearest to a place."""
    edges = zip(outline, (*outline[1:], outline[0]), strict=True)
    return min((nearest_on_segment(place, start, end) for start, end in edges), key=lambda each: math.dist(each, place))


def distance_from_segment(place: Place, start: Place, end: Place) -> float:
    """Return the distance of a place from a segment, in units."""
    share = _nearest_share(place, start, end)
    dx, dz = end[0] - start[0], end[1] - start[1]
    return math.hypot(place[0] - start[0] - share * dx, place[1] - start[1] - share * dz)


def distance_from_line(place: Place, start: Place, end: Place) -> float:
    """Return the distance of a place from the line through two others, in units; from `start` if these are equal."""
    (x, z), (x0, z0), (x1, z1) = place, start, end
    length = math.hypot(x1 - x0, z1 - z0)
    if length < 1e-6:
        return math.hypot(x - x0, z - z0)
    return abs((x1 - x0) * (z - z0) - (z1 - z0) * (x - x0)) / length


def max_deviation(path: Sequence[Place], first: int, last: int, start: Place, end: Place) -> float:
    """Return the maximum distance of a path's places `first` to `last` from the segment from start to end, in units."""
    return max(distance_from_segment(place, start, end) for place in path[first : last + 1])


def offset_seen_from(view: Place, place: Place, other: Place) -> tuple[float, float]:
    """Return how far `other` is to the right of `place` and behind it, for a viewer who looks at `place`, in units."""
    return Pose(*place, bearing(view, place)).local(*other)


def relation_offset(relation: str, right: float, behind: float) -> tuple[float, float] | None:
    """Return a landmark's offset in the direction that a relation to it implies, and across, in units.

    Args:
        relation: of a place to the landmark: "left_of", "right_of", "in_front_of" or "behind".
        right, behind: the landmark's offset from the place.

    Returns:
        None for any other relation.
    """
    offsets = {
        "left_of": (right, behind),
        "right_of": (-right, behind),
        "in_front_of": (behind, right),
        "behind": (-behind, right),
    }
    return offsets.get(relation)


def _nearest_share(place: Place, start: Place, end: Place) -> float:
    dx, dz = end[0] - start[0], end[1] - start[1]
    square = dx * dx + dz * dz
    share = ((place[0] - start[0]) * dx + (place[1] - start[1]) * dz) / square if square else 0.0
    return min(max(share, 0.0), 1.0)


# Legs


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


def legs_of(path: Sequence[Place]) -> list[Leg]:
    """Return the legs of a path; none if it does not move."""
    corners = simplify(path, LEG_TOLERANCE)
    changed = True
    while changed:
        changed = False
        for before, at, after in zip(corners, corners[1:], corners[2:], strict=False):
            if abs(turn_between(bearing(path[before], path[at]), bearing(path[at], path[after]))) < LEG_STRAIGHT:
                corners.remove(at)
                changed = True
                break
    return [
        Leg(path[a], path[b], a, b, bearing(path[a], path[b]), math.dist(path[a], path[b]))
        for a, b in pairwise(corners)
        if path[a] != path[b]
    ]


def simplify(
    path: Sequence[Place],
    tolerance: float,
    distance: Callable[[Place, Place, Place], float] = distance_from_segment,
) -> list[int]:
    """Return the indices of the places to which a path can be reduced (Douglas and Peucker), at least its two ends.

    Args:
        path: positions, at least one.
        tolerance: maximum distance of the path from the result, in units.
        distance: returns that of a place from the part between two others.
    """

    def between(first: int, last: int) -> list[int]:
        apart = {i: distance(path[i], path[first], path[last]) for i in range(first + 1, last)}
        farthest = max(apart, key=apart.__getitem__, default=first)
        if apart.get(farthest, 0.0) <= tolerance:
            return [first, last]
        return between(first, farthest)[:-1] + between(farthest, last)

    return between(0, len(path) - 1)


# Directions and bends


@dataclass(frozen=True, eq=False)
class PathGeometry:
    """Directions and bends of a path at each of its places.

    Attributes:
        places: distinct positions, in order.
        start_heading: of the walker at the first one, in degrees.
        goal: place that the walker faces at the last one.
    """

    places: Sequence[Place]
    start_heading: float
    goal: Place

    def heading_before(self, index: int) -> float:
        """Return the direction in which the path arrives at one of its places, in degrees."""
        if index == 0:
            return self.start_heading
        return bearing(self.places[max(index - STRIDE, 0)], self.places[index])

    def heading_after(self, index: int, stride: int = STRIDE) -> float:
        """Return the direction in which the path leaves one of its places, in degrees; at its end, that to the goal."""
        after = min(index + stride, len(self.places) - 1)
        return bearing(self.places[index], self.places[after] if after > index else self.goal)

    def heading_between(self, first: int, last: int) -> float:
        """Return the direction of the path from a place to a later one, in degrees; that of its start without one."""
        return self.start_heading if first >= last else bearing(self.places[first], self.places[last])

    def heading_of_move(self, index: int) -> float:
        """Return the direction of the path from one of its places to the next, in degrees; before the first, its start.

        Args:
            index: of the place; the last place and all beyond count as the last but one.
        """
        if index < 0:
            return self.start_heading
        at = min(index, len(self.places) - 2)
        return self.start_heading if at < 0 else bearing(self.places[at], self.places[at + 1])

    @cached_property
    def bends(self) -> dict[int, float]:
        """Degrees by which the path turns, positive clockwise, by the index of each bend's sharpest place."""
        turned = [turn_between(self.heading_before(at), self.heading_after(at)) for at in range(len(self.places))]
        found: dict[int, float] = {}
        for at, angle in enumerate(turned):
            around = turned[max(at - PEAK, 0) : at + PEAK + 1]
            if abs(angle) >= BEND and abs(angle) >= max(each * math.copysign(1.0, angle) for each in around):
                found[at] = angle
        return found

    @cached_property
    def wide_bends(self) -> list[float | None]:
        """Degrees by which the path turns around each of its places; see `_wide_bend`."""
        return [self._wide_bend(index) for index in range(len(self.places))]

    def places_around(self, index: int, reach: int) -> range:
        """Return the indices of the places of the path that are within `reach` places of one."""
        return range(max(index - reach, 0), min(index + reach + 1, len(self.places)))

    def nearest(self, place: Place, first: int, last: int) -> int:
        """Return the index, from `first` to `last`, where the path is nearest to a place; the first of several."""
        return min(range(first, min(last + 1, len(self.places))), key=lambda i: math.dist(self.places[i], place))

    def first_approach(self, x: float, z: float, since: int, limit: float) -> int | None:
        """Return the index of the closest place of the path's first approach to (x, z) within `limit`; None if none."""
        best, nearest = None, math.inf
        for index in range(since, len(self.places)):
            near = math.dist(self.places[index], (x, z))
            if near <= limit and near < nearest:
                best, nearest = index, near
            elif near > nearest + 1.0:
                break
        return best

    def straight_part(self, since: int, min_bend: float, back: int) -> dict[int, Pose]:
        """Return the places of the path up to its next bend, with the path's direction at each.

        The direction is measured within the straight part alone: places beyond its bends do not count.

        Args:
            since: index of the first place.
            min_bend: size of the bends that end the part, in degrees.
            back: number of places before the first that are included if they are on the same part.

        Returns:
            Poses by the index of their place.
        """
        found = {}
        strong = [at for at, angle in self.bends.items() if abs(angle) > min_bend]
        first = max((at for at in strong if at <= since), default=0)
        last = min((at for at in strong if at > since), default=len(self.places) - 1)
        for index in range(max(since - back, first), last + 1):
            # The places beside a bend's sharpest one belong to the bend, where the part is long enough.
            inner = (first + 1, last - 1) if last - first > STRIDE + 1 else (first, last)
            before = max(min(index - STRIDE, inner[1] - STRIDE), inner[0])
            after = min(max(index + STRIDE, inner[0] + STRIDE), inner[1])
            found[index] = Pose(*self.places[index], self.heading_between(before, after))
        return found

    def _wide_bend(self, index: int) -> float | None:
        """Return the change of the path's direction around a place, measured over several places on each side.

        A detour that ends within a few places, such as around a barrier, does not count.

        Returns:
            Degrees, positive clockwise; None near the path's ends.
        """
        before, after = index - WIDE_GAP, index + WIDE_GAP
        if before - WIDE_STRIDE < 0 or after + 2 >= len(self.places):
            return None
        last = min(after + WIDE_STRIDE, len(self.places) - 1)
        arrival = bearing(self.places[before - WIDE_STRIDE], self.places[before])
        return turn_between(arrival, bearing(self.places[after], self.places[last]))
