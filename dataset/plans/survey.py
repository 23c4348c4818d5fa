"""Survey of a plan: where its roads meet, bend and end, and which arms leave each of these places."""

import math
from dataclasses import dataclass
from itertools import combinations, pairwise

import numpy as np

from arramon_client.world import turn_between
from arramon_dataset.layout.grid import Mask, Points
from arramon_dataset.plans.plan import Plan
from arramon_dataset.plans.strips import inside

SHORTEST_ARM = 2.5
"""Length beyond a junction's open ground from which a piece of road is an arm, in units: a shorter one is a niche."""

SHARPEST_CURVE = 40.0
"""A road that turns by more degrees at one point has a bend there; by fewer, a curve, which is no junction."""

MERGED = 3.6
"""Maximum distance of meetings that look like one junction, in units."""

SQUARE_EDGE, AT_SQUARE = 0.5, 2.0
"""How far outside a square's corners its ground reaches, and a meeting belongs to it, in units."""

OPEN = 6.0
"""Maximum distance of a junction's open ground from where the middle lines meet, in units."""

BEFORE_END = 1.0
"""How far before the facade at a dead end its junction is, in units: where a walker stops."""

TOUCH = 0.5
"""Middle lines that come closer than this meet, in units."""

STEP = 0.25
"""Spacing at which roads are followed, in units."""

AHEAD = 2.0
"""Length over which an arm's direction is taken, in units."""

SAME_ARM = 25.0
"""Arms whose directions differ by fewer degrees are one, if their mouths are close."""

Place = tuple[float, float]


@dataclass(frozen=True, eq=False)
class MiddleLine:
    """A road's middle line.

    Attributes:
        number: of the street in the plan.
        half_width: in units.
        places: (n, 2) of (x, z), every STEP units or less.
        bends: indices of places at which it turns by more than SHARPEST_CURVE.
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

    def following(self, at: int, way: int) -> list[int]:
        """Return the indices of all places after `at`, forwards (way 1) or backwards (-1), to the line's end."""
        count = len(self.places)
        if self.closed:
            return [(at + way * i) % (count - 1) for i in range(1, count - 1)]
        return list(range(at + way, count if way > 0 else -1, way))

    def heading(self, at: int, way: int) -> float:
        """Return the direction of the line at a place, over the next AHEAD units, degrees clockwise from +z."""
        far = ([at, *self.following(at, way)])[: round(AHEAD / STEP) + 1][-1]
        (x0, z0), (x1, z1) = self.places[at].tolist(), self.places[far].tolist()
        return round(math.degrees(math.atan2(x1 - x0, z1 - z0)) % 360.0, 1) % 360.0


@dataclass(frozen=True, slots=True)
class Mouth:
    """Where a road leaves a junction: the track, the index of its first place outside, and the way on (1 or -1)."""

    track: int
    at: int
    way: int


@dataclass(frozen=True, eq=False)
class Meeting:
    """Where roads meet, bend or end: one node, or several that look like one junction.

    Attributes:
        nodes: (n, 2) of (x, z).
        corners: (m, 2) of (x, z) of the open square here; None if there is none.
        grounds: for each track here, the mask of its places on the open ground.
        mouths: where roads leave.
    """

    nodes: Points
    corners: Points | None
    grounds: dict[int, Mask]
    mouths: tuple[Mouth, ...]


def tracks_of(plan: Plan) -> tuple[MiddleLine, ...]:
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


def meetings_of(plan: Plan, tracks: tuple[MiddleLine, ...]) -> tuple[Meeting, ...]:
    """Return all places where a plan's roads meet, bend or end: squares first, then in the plan's order."""
    squares = [plan.world(np.array(square.corners)) for square in plan.squares]
    nodes = [*_crossings(tracks), *(track.places[i] for track in tracks for i in track.bends)]
    groups: list[list[Points]] = [[] for _ in squares]
    free: list[Points] = []
    for node in nodes:
        near = [i for i, corners in enumerate(squares) if _from_polygon(corners, node[None, :])[0] <= AT_SQUARE]
        (groups[near[0]] if near else free).append(node)
    ends = _dead_ends(tracks, squares)
    found = [_meeting(np.array(group).reshape(-1, 2), c, tracks) for group, c in zip(groups, squares, strict=True)]
    found += [_meeting(np.array(group), None, tracks) for group in _clusters(free)]
    return (*found, *(_meeting(end[None, :], None, tracks) for end in ends))


def _bend(three: Points) -> float:
    """Return by how many degrees a line through three places turns at the second."""
    (x0, z0), (x1, z1), (x2, z2) = three.tolist()
    after = math.degrees(math.atan2(x2 - x1, z2 - z1))
    return abs(turn_between(math.degrees(math.atan2(x1 - x0, z1 - z0)), after))


def _crossings(tracks: tuple[MiddleLine, ...]) -> list[Points]:
    """Return the (x, z) of all places where two middle lines meet."""
    found: list[Points] = []
    for one, other in combinations(tracks, 2):
        apart = other.distances(one.places).round(6)
        found += [one.places[first + int(apart[first:last].argmin())] for first, last in runs(apart < TOUCH)]
    return found


def _dead_ends(tracks: tuple[MiddleLine, ...], squares: list[Points]) -> list[Points]:
    """Return the (x, z) before the ends of roads that lead nowhere."""
    found = []
    for track in tracks:
        others = [other for other in tracks if other is not track]
        for at, way in () if track.closed else ((0, 1), (len(track.places) - 1, -1)):
            tail = track.places[[at, *track.following(at, way)][: round(SHORTEST_ARM / STEP)]]
            crossed = any((other.distances(tail) <= other.half_width).any() for other in others)
            if not crossed and not any((_from_polygon(corners, tail) <= SQUARE_EDGE).any() for corners in squares):
                found.append(tail[round(BEFORE_END / STEP)])
    return found


def _clusters(nodes: list[Points]) -> list[list[Points]]:
    """Return the nodes grouped: each is within MERGED units of another of its group. In order of the first of each."""
    groups: list[list[Points]] = []
    for node in nodes:
        near = [group for group in groups if any(math.dist(node, other) <= MERGED for other in group)]
        joined = [other for group in near for other in group] + [node]
        place = min((i for i, group in enumerate(groups) if any(group is n for n in near)), default=len(groups))
        groups = [group for group in groups if not any(group is n for n in near)]
        groups.insert(min(place, len(groups)), joined)
    return groups


def _meeting(nodes: Points, corners: Points | None, tracks: tuple[MiddleLine, ...]) -> Meeting:
    """Return a meeting with its open ground and where roads leave it."""
    grounds: dict[int, Mask] = {}
    here = [track for track in tracks if _meets(track, nodes, corners)]
    for track in here:
        ground = np.zeros(len(track.places), dtype=bool)
        if corners is not None:
            ground |= _from_polygon(corners, track.places) <= SQUARE_EDGE
        if len(nodes):
            close = _distances(track.places, nodes).min(axis=1) <= OPEN
            for other in here:
                if other is not track:
                    ground |= close & (other.distances(track.places) <= other.half_width)
            at = _distances(track.places, nodes)
            ground[at.argmin(axis=0)[at.min(axis=0) <= TOUCH]] = True
        grounds[track.number] = ground
    mouths = [mouth for track in here for mouth in _mouths(track, grounds[track.number])]
    return Meeting(nodes, corners, grounds, tuple(_without_doubles(mouths, tracks)))


def _meets(track: MiddleLine, nodes: Points, corners: Points | None) -> bool:
    if len(nodes) and _distances(track.places, nodes).min() <= TOUCH:
        return True
    return corners is not None and bool((_from_polygon(corners, track.places) <= SQUARE_EDGE).any())


def _mouths(track: MiddleLine, ground: Mask) -> list[Mouth]:
    """Return where a road leaves the open ground and goes on for at least the length of an arm."""
    found = []
    for first, last in runs(ground):
        for at, way in ((last - 1, 1), (first, -1)):
            onward = track.following(at, way)[: round(SHORTEST_ARM / STEP)]
            if len(onward) == round(SHORTEST_ARM / STEP) and not ground[onward].any():
                found.append(Mouth(track.number, onward[0], way))
    return found


def _without_doubles(mouths: list[Mouth], tracks: tuple[MiddleLine, ...]) -> list[Mouth]:
    """Return the mouths without those of narrower roads that leave at nearly the same place in the same direction."""
    kept: list[Mouth] = []
    for mouth in sorted(mouths, key=lambda m: -tracks[m.track].half_width):
        place, heading = tracks[mouth.track].places[mouth.at], tracks[mouth.track].heading(mouth.at, mouth.way)
        doubles = [
            other
            for other in kept
            if math.dist(place, tracks[other.track].places[other.at]) < MERGED
            and abs(turn_between(tracks[other.track].heading(other.at, other.way), heading)) < SAME_ARM
        ]
        if not doubles:
            kept.append(mouth)
    return kept


def runs(mask: Mask) -> list[tuple[int, int]]:
    """Return (first, after the last) of each run of true values, (n,)."""
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
