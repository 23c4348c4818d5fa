"""What is to be done in a section's streets: where a turn starts, what lies where, and the ground truth."""

from dataclasses import dataclass
from random import Random

import numpy as np
from scipy.spatial import cKDTree

from server.episodes.extras import Points, distracters
from server.episodes.generate.ground import Ground
from server.episodes.generate.motion import NEED, REACH_TO, Field, Walker
from server.sim.catalogue import ObjectType
from server.sim.collectibles import height_of
from server.sim.geometry import Point, Pose, wrap
from server.sim.rules import STEPS_PER_PHASE, Action, Collectible, moved
from server.sim.section import Section

LATTICE = 0.5
"""Starts, targets and distracters have whole coordinates and a half: a lattice of spacing 1, as in the original."""

OPEN = 0.5
"""Units that starts, targets and distracters stay away from everything solid."""

LENGTHS = (
    (4, 5, 3), (5, 10, 11), (10, 15, 13), (15, 20, 13), (20, 25, 13), (25, 30, 12), (30, 35, 11), (35, 40, 9),
    (40, 50, 10), (50, 60, 4), (60, 80, 1),
)  # fmt: skip
"""How many points a path is to have: from, below, and how often of a hundred. As in the original, with mean 24."""

SLACK = 1.0
"""Units by which a way to a target may be longer or shorter than wanted."""

STRAIGHTER = 0.93
"""How long the fields' ways are, which may cut corners, beside the ground truth's."""

HEADINGS = (45, 2, 2, 12, 2, 2, 15, 2, 2, 12, 2, 2)
"""How often, of a hundred, a turn 1 starts at each multiple of 30 degrees off the section's heading."""

LANDMARK, BESIDE_LANDMARK = 2.5, 0.85
"""Targets this near to street furniture, in units, are preferred; this often no other is taken."""

MOST_ACTIONS = STEPS_PER_PHASE - 10
"""A ground truth of more actions would leave an agent no room for a mistake."""


@dataclass(frozen=True, slots=True)
class Errand:
    """One turn's navigation.

    Attributes:
        start, end: poses.
        path: the ground truth's distinct positions (x, z), in units.
        actions: the ground truth's, the pick-up included.
        street: the objects in the street; the first is the target.
    """

    start: Pose
    end: Pose
    path: tuple[tuple[float, float], ...]
    actions: tuple[Action, ...]
    street: tuple[Collectible, ...]


class Streets:
    """Draws errands in one section. It belongs to one thread.

    Args:
        section: where.

    Raises:
        ValueError: if the section has no open ground.
    """

    def __init__(self, section: Section) -> None:
        self._section = section
        self.ground = Ground.of(section)
        self._walker = Walker(self.ground)
        self._places = self._connected(lattice(self.ground, section))
        if not len(self._places):
            raise ValueError(f"section {section.id} has no open ground")
        self._columns, self._rows = np.array([self.ground.node(x, z) for x, z in self._places.tolist()]).T
        props = np.array([(prop.x, prop.z) for prop in section.props]).reshape(-1, 2)
        distance = cKDTree(props).query(self._places)[0] if len(props) else np.full(len(self._places), np.inf)
        self._is_beside_landmark = distance <= LANDMARK

    @property
    def places(self) -> Points:
        """(n, 2) of (x, z): where starts and objects can be."""
        return self._places

    def draw_start(self, random: Random) -> Pose:
        """Where a turn 1 begins."""
        x, z = self._places[random.randrange(len(self._places))].tolist()
        (offset,) = random.choices(range(len(HEADINGS)), HEADINGS)
        return Pose(x, z, round(wrap(self._section.heading + 30.0 * offset), 6))

    def draw_errand(
        self, key: str, turn: int, start: Pose, target: ObjectType, points: int, random: Random
    ) -> Errand | None:
        """A turn from `start`; None where chance found no way of the length wanted.

        Args:
            key: draws the distracters.
            turn: 1 or 2.
            start: where it begins.
            target: what is to be picked up.
            points: how many the path is to have, about.
            random: draws the rest.
        """
        place = self._draw_target(points, self._walker.field(start.x, start.z), random)
        if place is None:
            return None
        actions = self._walker.actions(start, place, self._walker.field(*place))
        if not actions or len(actions) > MOST_ACTIONS:
            return None
        path, end = followed(start, actions)
        if len(path) < LENGTHS[0][0]:
            return None
        lying = Point(place[0], 0.0, place[1])
        others = distracters(key, turn, target, lying, np.array(path), end, self._places)
        street = tuple(
            Collectible(kind, Point(at.x, round(height_of(kind.kind) / 2, 3), at.z))
            for kind, at in ((target, lying), *others)
        )
        return Errand(start, end, path, (*actions, Action.INTERACT), street)

    def _draw_target(self, points: int, field: Field, random: Random) -> tuple[float, float] | None:
        """A place to which the way has about so many points."""
        length = field.length[self._columns, self._rows] / 1000.0
        wanted = STRAIGHTER * (points - 1) + REACH_TO - 0.5
        fitting = np.flatnonzero(np.abs(length - wanted) <= SLACK)
        preferred = fitting[self._is_beside_landmark[fitting]]
        if len(preferred) and random.random() < BESIDE_LANDMARK:
            fitting = preferred
        if not len(fitting):
            return None
        x, z = self._places[fitting[random.randrange(len(fitting))]].tolist()
        return x, z

    def _connected(self, places: Points) -> Points:
        """Those of the places that can be reached from most of the others."""
        left = places
        while len(left):
            cost = self._walker.field(*left[0].tolist()).cost
            columns, rows = np.array([self.ground.node(x, z) for x, z in left.tolist()]).T
            reached = cost[columns, rows] < np.iinfo(np.int32).max
            if 2 * reached.sum() > len(places) or 2 * reached.sum() > len(left):
                found: Points = left[reached]
                return found
            reached[0] = True  # A place whose own node is not free reaches nothing.
            left = left[~reached]
        return left


def lattice(ground: Ground, section: Section) -> Points:
    """(n, 2) of (x, z): the lattice's places on open ground."""
    x0, z0, x1, z1 = section.bounds
    xs, zs = (np.arange(np.ceil(low - LATTICE), high - LATTICE) + LATTICE for low, high in ((x0, x1), (z0, z1)))
    places: Points = np.stack(np.meshgrid(xs, zs, indexing="ij"), axis=-1).reshape(-1, 2)
    clear = np.array([ground.clear_at(x, z) >= max(OPEN, NEED / 1000.0) for x, z in places.tolist()], dtype=bool)
    return places[clear & (ground.solids.distance(places) >= OPEN)]


def draw_length(random: Random) -> int:
    """How many points a path is to have."""
    ((first, end, _),) = random.choices(LENGTHS, [weight for _, _, weight in LENGTHS])
    return random.randrange(first, end)


def followed(start: Pose, actions: list[Action]) -> tuple[tuple[tuple[float, float], ...], Pose]:
    """The distinct positions of free moves, rounded to a millionth of a unit, and the last pose as it is."""
    path, pose = [(start.x, start.z)], start
    for action in actions:
        pose = moved(pose, action)
        if action is Action.FORWARD:
            path.append((round(pose.x, 6), round(pose.z, 6)))
    return tuple(path), pose
