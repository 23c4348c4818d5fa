"""Detection of a plan's junctions (where roads meet, bend or end) and of the roads that leave each of them."""

import math
from dataclasses import dataclass
from itertools import combinations, pairwise

import numpy as np

from arramon_client.world import turn_between
from arramon_dataset.layout.grid import Mask, Points
from arramon_dataset.plans.plan import Plan
from arramon_dataset.plans.street_surface import inside

SHORTEST_ARM = 2.5
"""Minimum length of an arm beyond a junction's open ground, in units: a shorter piece of road is a niche."""

SHARPEST_CURVE = 40.0
"""Maximum turn of a road at one point that counts as a curve, in degrees; a sharper turn is a bend, which is a
junction."""

MERGED = 3.6
"""Maximum distance of meetings that are merged into one junction, in units."""

SQUARE_EDGE, AT_SQUARE = 0.5, 2.0
"""Margins around a square's corners within which a place is on its ground, and a meeting belongs to it, in units."""

OPEN = 6.0
"""Maximum distance between a junction's open ground and the point where the middle lines meet, in units."""

BEFORE_END = 1.0
"""Distance between the facade at a dead end and its junction, in units: where a walker stops."""

TOUCH = 0.5
"""Distance below which two middle lines meet, in units."""

STEP = 0.25
"""Spacing at which roads are followed, in units."""

AHEAD = 2.0
"""Length over which an arm's direction is measured, in units."""

SAME_ARM = 25.0
"""Maximum difference in direction, in degrees, of arms that are merged if they start close to each other."""

Place = tuple[float, float]


@dataclass(frozen=True, eq=False)
class MiddleLine:
    """A road's middle line.

    Attributes:
        number: index of the street in the plan.
        half_width: in units.
        places: (n, 2) of (x, z), every STEP units or less.
        bends: indices of the places where it turns by more than SHARPEST_CURVE.
        closed: whether it ends where it starts; the last place is then the first.
    """

    number: int
    half_width: float
    places: Points
    bends: tuple[int, ...]
    closed: bool

    def distances(self, places: Points) -> Points:
        """Return the distance of each of `places` (n, 2) from the line, in units, (n,); exact to STEP / 2."""
        nearest: Points = np.hypot(
            places[:, None, 0] - self.places[None, :, 0], places[:, None, 1] - self.places[None, :, 1]
        ).min(axis=1)
        return nearest

    def following(self, at: int, direction: int) -> list[int]:
        """Return the indices of all places after `at`, forwards (direction 1) or backwards (-1), to the line's end."""
        count = len(self.places)
        if self.closed:
            return [(at + direction * i) % (count - 1) for i in range(1, count - 1)]
        return list(range(at + direction, count if direction > 0 else -1, direction))

    def heading(self, at: int, direction: int) -> float:
        """Return the direction of the line at a place, over the next AHEAD units, degrees clockwise from +z."""
        far = ([at, *self.following(at, direction)])[: round(AHEAD / STEP) + 1][-1]
        (x0, z0), (x1, z1) = self.places[at].tolist(), self.places[far].tolist()
        return round(math.degrees(math.atan2(x1 - x0, z1 - z0)) % 360.0, 1) % 360.0


@dataclass(frozen=True, slots=True)
class Mouth:
    """The point where a road leaves a junction.

    Attributes:
        line: index of the road's middle line.
        at: index of its first place outside the junction.
        direction: away from the junction: 1 forwards along the line, -1 backwards.
    """

    line: int
    at: int
    direction: int


@dataclass(frozen=True, eq=False)
class DetectedJunction:
    """A place where roads meet, bend or end: one node, or several that look like one junction.

    Attributes:
        nodes: (n, 2) of (x, z).
        corners: (m, 2) of (x, z) of the open square here; None if there is none.
        grounds: by index of each middle line here, the mask of its places on the open ground.
        mouths: where roads leave.
    """

    nodes: Points
    corners: Points | None
    grounds: dict[int, Mask]
    mouths: tuple[Mouth, ...]


def middle_lines_of(plan: Plan) -> tuple[MiddleLine, ...]:
    """Return the middle lines of all streets of a plan, in its order."""
    found = []
    for number, (street, line) in enumerate(zip(plan.streets, plan.lines(), strict=True)):
        pieces, vertices = [line[:1]], [0]
        for start, end in pairwise(line):
            count = math.ceil(math.dist(start, end) / STEP)
            pieces.append(start + (np.arange(1, count + 1) / count)[:, None] * (end - start))
            vertices.append(vertices[-1] + count)
        places = np.concatenate(pieces).round(6)
        closed = math.dist(line[0], line[-1]) < STEP
        corners = list(zip(vertices, vertices[1:], vertices[2:], strict=False))
        if closed:
            corners.append((vertices[-2], 0, vertices[1]))
        bends = tuple(at for before, at, after in corners if _bend(places[[before, at, after]]) > SHARPEST_CURVE)
        found.append(MiddleLine(number, street.width / 2, places, bends, closed))
    return tuple(found)


def detect_junctions(plan: Plan, lines: tuple[MiddleLine, ...]) -> tuple[DetectedJunction, ...]:
    """Return all places where a plan's roads meet, bend or end: squares first, then in the plan's order."""
    squares = [plan.world(np.array(square.corners)) for square in plan.squares]
    nodes = [*_crossings(lines), *(line.places[i] for line in lines for i in line.bends)]
    groups: list[list[Points]] = [[] for _ in squares]
    free: list[Points] = []
    for node in nodes:
        near = [i for i, corners in enumerate(squares) if _from_polygon(corners, node[None, :])[0] <= AT_SQUARE]
        (groups[near[0]] if near else free).append(node)
    ends = _dead_ends(lines, squares)
    found = [
        _detected_junction(np.array(group).reshape(-1, 2), c, lines) for group, c in zip(groups, squares, strict=True)
    ]
    found += [_detected_junction(np.array(group), None, lines) for group in _clusters(free)]
    return (*found, *(_detected_junction(end[None, :], None, lines) for end in ends))


def _bend(three: Points) -> float:
    """Return the angle by which a line through three places turns at the second, in degrees."""
    (x0, z0), (x1, z1), (x2, z2) = three.tolist()
    after = math.degrees(math.atan2(x2 - x1, z2 - z1))
    return abs(turn_between(math.degrees(math.atan2(x1 - x0, z1 - z0)), after))


def _crossings(lines: tuple[MiddleLine, ...]) -> list[Points]:
    """Return the (x, z) of all places where two middle lines meet."""
    found: list[Points] = []
    for one, other in combinations(lines, 2):
        apart = other.distances(one.places).round(6)
        found += [one.places[first + int(apart[first:last].argmin())] for first, last in true_ranges(apart < TOUCH)]
    return found


def _dead_ends(lines: tuple[MiddleLine, ...], squares: list[Points]) -> list[Points]:
    """Return the (x, z) of the junctions at dead ends."""
    found = []
    for line in lines:
        others = [other for other in lines if other is not line]
        for at, direction in () if line.closed else ((0, 1), (len(line.places) - 1, -1)):
            tail = line.places[[at, *line.following(at, direction)][: round(SHORTEST_ARM / STEP)]]
            crossed = any((other.distances(tail) <= other.half_width).any() for other in others)
            if not crossed and not any((_from_polygon(corners, tail) <= SQUARE_EDGE).any() for corners in squares):
                found.append(tail[round(BEFORE_END / STEP)])
    return found


def _clusters(nodes: list[Points]) -> list[list[Points]]:
    """Group nodes that are within MERGED units of each other, directly or through others; in order of first nodes."""
    groups: list[list[Points]] = []
    for node in nodes:
        near = [group for group in groups if any(math.dist(node, other) <= MERGED for other in group)]
        joined = [other for group in near for other in group] + [node]
        place = min((i for i, group in enumerate(groups) if any(group is n for n in near)), default=len(groups))
        groups = [group for group in groups if not any(group is n for n in near)]
        groups.insert(min(place, len(groups)), joined)
    return groups


def _detected_junction(nodes: Points, corners: Points | None, lines: tuple[MiddleLine, ...]) -> DetectedJunction:
    """Return a junction with its open ground and the mouths of its roads."""
    grounds: dict[int, Mask] = {}
    here = [line for line in lines if _passes_through(line, nodes, corners)]
    for line in here:
        ground = np.zeros(len(line.places), dtype=bool)
        if corners is not None:
            ground |= _from_polygon(corners, line.places) <= SQUARE_EDGE
        if len(nodes):
            close = _distances(line.places, nodes).min(axis=1) <= OPEN
            for other in here:
                if other is not line:
                    ground |= close & (other.distances(line.places) <= other.half_width)
            at = _distances(line.places, nodes)
            ground[at.argmin(axis=0)[at.min(axis=0) <= TOUCH]] = True
        grounds[line.number] = ground
    mouths = [mouth for line in here for mouth in _mouths(line, grounds[line.number])]
    return DetectedJunction(nodes, corners, grounds, tuple(_without_doubles(mouths, lines)))


def _passes_through(line: MiddleLine, nodes: Points, corners: Points | None) -> bool:
    if len(nodes) and _distances(line.places, nodes).min() <= TOUCH:
        return True
    return corners is not None and bool((_from_polygon(corners, line.places) <= SQUARE_EDGE).any())


def _mouths(line: MiddleLine, ground: Mask) -> list[Mouth]:
    """Return the points where a road leaves the open ground and continues for at least the length of an arm."""
    found = []
    for first, last in true_ranges(ground):
        for at, direction in ((last - 1, 1), (first, -1)):
            onward = line.following(at, direction)[: round(SHORTEST_ARM / STEP)]
            if len(onward) == round(SHORTEST_ARM / STEP) and not ground[onward].any():
                found.append(Mouth(line.number, onward[0], direction))
    return found


def _without_doubles(mouths: list[Mouth], lines: tuple[MiddleLine, ...]) -> list[Mouth]:
    """Drop the mouths of narrower roads that leave at nearly the same place in the same direction."""
    kept: list[Mouth] = []
    for mouth in sorted(mouths, key=lambda m: -lines[m.line].half_width):
        place, heading = lines[mouth.line].places[mouth.at], lines[mouth.line].heading(mouth.at, mouth.direction)
        doubles = [
            other
            for other in kept
            if math.dist(place, lines[other.line].places[other.at]) < MERGED
            and abs(turn_between(lines[other.line].heading(other.at, other.direction), heading)) < SAME_ARM
        ]
        if not doubles:
            kept.append(mouth)
    return kept


def true_ranges(mask: Mask) -> list[tuple[int, int]]:
    """Return the half-open index range (start, stop) of each run of true values of a mask (n,)."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(np.int8)))
    return list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))


def _from_polygon(corners: Points, places: Points) -> Points:
    """Return the distance of places (n, 2) from a polygon (m, 2), in units, (n,); 0 inside."""
    nearest = np.full(len(places), np.inf)
    for start, end in pairwise([*corners, corners[0]]):
        along = end - start
        share = np.clip(((places - start) * along).sum(axis=1) / (along * along).sum(), 0.0, 1.0)
        np.minimum(nearest, np.hypot(*(places - start - share[:, None] * along).T), out=nearest)
    distance: Points = np.where(inside(corners, places), 0.0, nearest).round(6)
    return distance


def _distances(one: Points, other: Points) -> Points:
    apart: Points = np.hypot(one[:, None, 0] - other[None, :, 0], one[:, None, 1] - other[None, :, 1])
    return apart
