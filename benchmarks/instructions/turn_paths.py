"""Paths of turns from a data set's files, as straight legs between bends, and what they pass on each side."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

Place = tuple[float, float]

MAX_LEG_DEVIATION = 1.0
"""Maximum distance of a path from the straight legs that it is reduced to, in units."""

MIN_BEND, MIN_STATED_BEND = 35.0, 50.0
"""Minimum angles of a bend that a text can call a turn, and of one that it must mention, in degrees."""

MERGE_DISTANCE = 4.6
"""Distance below which bends are merged, in units, as walkers turn over several steps."""

ABEAM = (60.0, 120.0)
"""Range of angles between the path and a thing beside the walker, in degrees."""

MAX_PASSING_DISTANCE, MIN_SIDE_DISTANCE = 7.0, 0.7
"""Maximum distance of a passed thing, and minimum distance from the path of a thing on one side, in units."""

SHARES = (0.0, 0.25, 0.5, 0.75, 1.0)
"""Sample positions along a step of the path, as shares of its length."""

MARGIN = 1e-6
"""Tolerance of path lengths, in units."""


@dataclass(frozen=True)
class Bend:
    """A change of direction.

    Attributes:
        start, end: path length at its start and end, in units.
        angle: in degrees, positive clockwise.
    """

    start: float
    end: float
    angle: float


@dataclass(frozen=True)
class PathStep:
    """The part of a path between two of its places: path length before it, its ends, and the heading of its leg."""

    since: float
    start: Place
    end: Place
    heading: float


class NavigationPath:
    """The navigation path of a turn.

    Args:
        path: places (x, z).
        heading: before the first step, in degrees.

    Attributes:
        steps: in order, each with the direction of the straight leg that it belongs to, in degrees.
        bends: between the legs, in order; the first may be at the start.
        length: of the path, in units.
    """

    def __init__(self, path: Sequence[Place], heading: float) -> None:
        self.steps: list[PathStep] = []
        self.length, legs = 0.0, []
        for first, last in pairwise(_reduced(path, 0, len(path) - 1)):
            towards = bearing(path[first], path[last])
            legs.append((self.length, turned(heading, towards)))
            heading = towards
            for start, end in pairwise(path[first : last + 1]):
                self.steps.append(PathStep(self.length, start, end, towards))
                self.length += math.dist(start, end)
        self.bends = list(_joined_bends(legs))

    def is_passed(self, ground: Sequence[Place], side: str, since: float, until: float) -> bool:
        """Return whether a part of the path passes a thing on a side.

        Args:
            ground: corners of the thing, or its single place.
            side: "left" or "right".
            since, until: path length at the start and end of the part, in units.
        """
        sign = 1.0 if side == "right" else -1.0
        for step in self.steps:
            if step.since < since - MARGIN or step.since + math.dist(step.start, step.end) > until + MARGIN:
                continue
            for place in (_between(step.start, step.end, share) for share in SHARES):
                to = nearest(ground, place)
                far, angle = math.dist(place, to), sign * turned(step.heading, bearing(place, to))
                if ABEAM[0] <= angle <= ABEAM[1] and MIN_SIDE_DISTANCE <= far <= MAX_PASSING_DISTANCE:
                    return True
        return False


def _joined_bends(legs: Sequence[tuple[float, float]]) -> Iterator[Bend]:
    """Yield the bends between legs, merging close ones to the same side."""
    group: list[tuple[float, float]] = []
    for since, angle in legs:
        is_apart = group and (since - group[-1][0] > MERGE_DISTANCE or group[-1][0] == 0.0)
        if group and (is_apart or angle * group[-1][1] < 0.0):
            yield Bend(group[0][0], group[-1][0], sum(each for _, each in group))
            group = []
        group.append((since, angle))
    if group:
        yield Bend(group[0][0], group[-1][0], sum(each for _, each in group))


def turn_path(turn: dict[str, Any], start: dict[str, float], before: Sequence[int]) -> NavigationPath:
    """Return the path of a turn from a data set's file.

    Args:
        turn: turn of an episode.
        start: start pose of the episode.
        before: navigation actions of the previous turn; empty for the first.
    """
    heading = start["heading"] + 30.0 * (list(before).count(2) - list(before).count(1))
    return NavigationPath([(x, z) for x, z in turn["path"]], heading % 360.0)


def bearing(start: Place, end: Place) -> float:
    """Return the direction from one place to another, in degrees clockwise from +z."""
    return math.degrees(math.atan2(end[0] - start[0], end[1] - start[1]))


def turned(before: float, after: float) -> float:
    """Return the turn from one direction to another, in degrees from -180 to 180, positive clockwise."""
    return (after - before + 180.0) % 360.0 - 180.0


def nearest(ground: Sequence[Place], place: Place) -> Place:
    """Return the place of a thing's outline that is nearest to another place."""
    if len(ground) == 1:
        return ground[0]
    edges = zip(ground, [*ground[1:], ground[0]], strict=True)
    return min((_onto(place, *edge) for edge in edges), key=lambda found: math.dist(found, place))


def rectangle(x: float, z: float, heading: float, halves: tuple[float, float]) -> list[Place]:
    """Return the corners of a rectangle with half sizes across and along its heading, in units."""
    sin, cos = math.sin(math.radians(heading)), math.cos(math.radians(heading))
    signs = ((-1, -1), (-1, 1), (1, 1), (1, -1))
    across, along = halves
    return [(x + a * across * cos + b * along * sin, z - a * across * sin + b * along * cos) for a, b in signs]


def _between(start: Place, end: Place, share: float) -> Place:
    return start[0] + share * (end[0] - start[0]), start[1] + share * (end[1] - start[1])


def _reduced(path: Sequence[Place], first: int, last: int) -> list[int]:
    """Return the indices of a path's ends and bends, by Douglas and Peucker."""
    apart = [math.dist(path[at], _onto(path[at], path[first], path[last])) for at in range(first, last + 1)]
    farthest = max(range(len(apart)), key=apart.__getitem__)
    if apart[farthest] <= MAX_LEG_DEVIATION:
        return [first, last] if last > first else [first]
    return _reduced(path, first, first + farthest)[:-1] + _reduced(path, first + farthest, last)


def _onto(place: Place, start: Place, end: Place) -> Place:
    dx, dz = end[0] - start[0], end[1] - start[1]
    square = dx * dx + dz * dz
    share = ((place[0] - start[0]) * dx + (place[1] - start[1]) * dz) / square if square else 0.0
    share = min(max(share, 0.0), 1.0)
    return _between(start, end, share)
