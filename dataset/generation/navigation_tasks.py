"""Random navigation tasks in a section's streets: start poses, objects and ground truth."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from random import Random

import numpy as np
from scipy.spatial import cKDTree

from arramon_client.world import STEPS_PER_PHASE, Action
from arramon_dataset.generation.clearance_raster import ClearanceRaster
from arramon_dataset.generation.path_planner import REACH_TO, STEP_CLEARANCE, CostField, PathPlanner
from arramon_dataset.generation.sidesteps import with_sidesteps
from arramon_dataset.release.missing_objects import Points, distance_to_path, draw_distracters, in_pick_up_box, is_apart
from arramon_server.sim.assets.collectibles import height_of
from arramon_server.sim.catalogue import ObjectType
from arramon_server.sim.geometry import Point, Pose, wrap
from arramon_server.sim.rules import Collectible, moved
from arramon_server.sim.section import Section

LATTICE = 0.5
"""Offset of a lattice of spacing 1 that holds all starts, targets and distracters, as in the original."""

TWINS_APART = 8.0
"""Minimum distance of two objects of one type in a street, in units: far enough that reaching one is
not reaching the other."""

MIN_CLEARANCE = 0.5
"""Minimum distance of starts, targets and distracters from everything solid, in units."""

LENGTHS = (
    (4, 5, 2), (5, 10, 5), (10, 15, 7), (15, 20, 8), (20, 25, 11), (25, 30, 13), (30, 35, 13), (35, 40, 14),
    (40, 50, 16), (50, 60, 8), (60, 80, 3),
)  # fmt: skip
"""Distribution of the number of points of a path: (from, below, percent). Longer than the original's, as more of the
long paths are rejected because no valid instruction is found for them."""

SLACK = 1.0
"""Maximum difference between the drawn and the actual length of a path, in units."""

FIELD_LENGTH_RATIO = 0.93
"""Ratio of path lengths in a cost field, which may cut corners, to those of the ground truth."""

HEADINGS = (45, 2, 2, 12, 2, 2, 15, 2, 2, 12, 2, 2)
"""Percentage of turn 1 starts at each multiple of 30 degrees from the section's heading."""

LANDMARK_DISTANCE, LANDMARK_SHARE = 2.5, 0.85
"""Maximum distance to street furniture of preferred target places, in units, and probability of drawing only from
these."""

NEIGHBOUR_SHARE = 0.3
"""Share of turns with a distracter beside the target, which instructions can refer to ("behind the green ball")."""

NEIGHBOUR_DISTANCE, NEIGHBOUR_PATH_DISTANCE = (1.2, 2.6), 0.8
"""Range of that distracter's distance from the target, and its minimum distance from the path, in units."""

TWIN_SHARE = 0.75
"""Share of turns with a twin, another object of the target's type off the path, if a place is found: only the
instruction tells the two apart, by their surroundings."""

TWIN_PATH, TWIN_NEARER = 3.0, 0.9
"""Minimum distance of the twin from the path, in units, and maximum ratio of the path length to it and to the target:
an agent that looks only for the type finds the twin first."""

TWIN_TRIED = 60
"""Maximum number of places tried for the twin."""

IN_VIEW = 60.0
"""Maximum angle from the first heading at which the twin is preferred, in degrees: a look to both sides shows it."""

STRAIGHT = 2
"""Number of candidate targets, of which the one with the longest straight-line distance from the start is taken: half
of the original's paths have no bend, and their ends are as far apart as 0.87 of their length, on average."""

FIRST_TURNS_KEPT = ((5, 90, 65, 30, 85, 100, 40), (30, 30, 55, 100, 85, 90, 100))
"""Percentage of paths kept in turn 1 and turn 2, by the number of turns before the first step, for the original's
distributions."""

MAX_ACTIONS = STEPS_PER_PHASE - 10
"""Maximum number of actions of a ground truth, which leaves agents a margin for mistakes."""


@dataclass(frozen=True, slots=True)
class NavigationTask:
    """The navigation task of one turn.

    Attributes:
        start, end: poses.
        path: distinct positions (x, z) of the ground truth, in units.
        actions: actions of the ground truth, the pick-up included.
        street: the objects in the street; the first is the target.
    """

    start: Pose
    end: Pose
    path: tuple[tuple[float, float], ...]
    actions: tuple[Action, ...]
    street: tuple[Collectible, ...]


class NavigationTaskSampler:
    """Samples navigation tasks in one section. Not thread-safe.

    Args:
        section: where the tasks take place.

    Raises:
        ValueError: if the section has no open ground.
    """

    def __init__(self, section: Section) -> None:
        self._section = section
        self.ground = ClearanceRaster.of(section)
        self._planner = PathPlanner(self.ground)
        self._places = self._connected(lattice(self.ground, section))
        if not len(self._places):
            raise ValueError(f"section {section.id} has no open ground")
        self._columns, self._rows = np.array([self.ground.node(x, z) for x, z in self._places.tolist()]).T
        props = np.array([(prop.x, prop.z) for prop in section.props]).reshape(-1, 2)
        distance = cKDTree(props).query(self._places)[0] if len(props) else np.full(len(self._places), np.inf)
        self._is_beside_landmark = distance <= LANDMARK_DISTANCE
        self._last_field: tuple[Pose, CostField] | None = None

    @property
    def places(self) -> Points:
        """(n, 2) of (x, z): possible places of starts and objects."""
        return self._places

    def draw_start(self, random: Random) -> Pose:
        """Return a random start pose for turn 1."""
        x, z = self._places[random.randrange(len(self._places))].tolist()
        (offset,) = random.choices(range(len(HEADINGS)), HEADINGS)
        return Pose(x, z, round(wrap(self._section.heading + 30.0 * offset), 6))

    def draw_navigation_task(
        self, key: str, turn: int, start: Pose, target: ObjectType, points: int, random: Random
    ) -> NavigationTask | None:
        """Return a navigation task from `start`, or None if no path of the wanted length was drawn.

        Args:
            key: seeds the distracters.
            turn: 1 or 2.
            start: pose at the beginning of the turn.
            target: type of the object to pick up.
            points: approximate number of points of the path.
            random: draws everything else.
        """
        field = self._field_of(start)
        place = self._draw_target(points, start, field, random)
        if place is None:
            return None
        actions = self._planner.actions(start, place, self._planner.field(*place))
        if not actions or random.randrange(100) >= FIRST_TURNS_KEPT[turn - 1][_turns_first(actions)]:
            return None
        actions = with_sidesteps(self.ground, start, actions, place, random)
        if len(actions) > MAX_ACTIONS:
            return None
        path, end = follow_actions(start, actions)
        if len(path) < LENGTHS[0][0]:
            return None
        lying = Point(place[0], 0.0, place[1])
        others = draw_distracters(key, turn, target, lying, np.array(path), end, self._places)
        if others and others[-1][0].kind != target.kind and random.random() < NEIGHBOUR_SHARE:
            beside = self._neighbour(lying, np.array(path), end, [at for _, at in others[:-1]], random)
            others = (*others[:-1], (others[-1][0], beside or others[-1][1]))
        if random.random() < TWIN_SHARE:
            twin = self._twin(lying, np.array(path), start, field, [at for _, at in others[1:]], random)
            others = others if twin is None else ((target, twin), *others[1:])
        street = tuple(
            Collectible(kind, Point(at.x, round(height_of(kind.kind) / 2, 3), at.z))
            for kind, at in ((target, lying), *others)
        )
        return NavigationTask(start, end, path, (*actions, Action.INTERACT), street)

    def _field_of(self, start: Pose) -> CostField:
        """Return the cost field of a start. The last one is cached, as several turns are drawn from one start."""
        if self._last_field is None or self._last_field[0] != start:
            self._last_field = start, self._planner.field(start.x, start.z)
        return self._last_field[1]

    def _length(self, field: CostField) -> Points:
        """Return the length of the cheapest path to each of the places, in units, (n,)."""
        length: Points = field.length[self._columns, self._rows] / 1000.0
        return length

    def _draw_target(self, points: int, start: Pose, field: CostField, random: Random) -> tuple[float, float] | None:
        """Return a random place to which the path has about `points` points."""
        length = self._length(field)
        wanted = FIELD_LENGTH_RATIO * (points - 1) + REACH_TO - 0.5
        fitting = np.flatnonzero(np.abs(length - wanted) <= SLACK)
        preferred = fitting[self._is_beside_landmark[fitting]]
        if len(preferred) and random.random() < LANDMARK_SHARE:
            fitting = preferred
        if not len(fitting):
            return None
        drawn = [self._places[fitting[random.randrange(len(fitting))]].tolist() for _ in range(STRAIGHT)]
        x, z = max(drawn, key=lambda place: (round(math.dist(place, (start.x, start.z)), 6), place))
        return x, z

    def _twin(
        self, target: Point, path: Points, start: Pose, field: CostField, others: Sequence[Point], random: Random
    ) -> Point | None:
        """Return a place for a twin, another object of the target's type, or None if there is none.

        The place is off the path, nearer to the start than the target, and if possible in view from the start.
        """
        own = field.length[self.ground.node(target.x, target.z)] / 1000.0
        near = np.flatnonzero(self._length(field) < TWIN_NEARER * own)
        tried = self._places[near[random.sample(range(len(near)), min(TWIN_TRIED, len(near)))]]
        far = np.hypot(tried[:, 0] - target.x, tried[:, 1] - target.z)
        tried = tried[(distance_to_path(tried, path) >= TWIN_PATH) & (far >= TWINS_APART)]
        taken = [np.array((at.x, at.z)) for at in others]
        free = [place for place in tried if is_apart(place, taken)]
        shown = [place for place in free if self._is_in_view(start, *place.tolist())]
        if not free:
            return None
        x, z = (shown or free)[0].tolist()
        return Point(x, 0.0, z)

    def _is_in_view(self, pose: Pose, x: float, z: float) -> bool:
        """Return whether a place is in view after a look to both sides from a pose."""
        right, ahead = pose.local(x, z)
        return abs(math.degrees(math.atan2(right, ahead))) <= IN_VIEW and self.ground.is_in_sight(pose.x, pose.z, x, z)

    def _neighbour(
        self, target: Point, path: Points, end: Pose, others: Sequence[Point], random: Random
    ) -> Point | None:
        """Return a place beside the target for a distracter that can identify it, or None if there is none."""
        far = np.hypot(self._places[:, 0] - target.x, self._places[:, 1] - target.z)
        near = self._places[(far >= NEIGHBOUR_DISTANCE[0]) & (far <= NEIGHBOUR_DISTANCE[1])]
        taken = [np.array((at.x, at.z)) for at in others]
        free = [
            place
            for place in near[distance_to_path(near, path) >= NEIGHBOUR_PATH_DISTANCE]
            if not in_pick_up_box(end, place) and is_apart(place, taken)
        ]
        if not free:
            return None
        x, z = random.choice(free).tolist()
        return Point(x, 0.0, z)

    def _connected(self, places: Points) -> Points:
        """Return the places that can be reached from most of the others."""
        left = places
        while len(left):
            cost = self._planner.field(*left[0].tolist()).cost
            columns, rows = np.array([self.ground.node(x, z) for x, z in left.tolist()]).T
            reached = cost[columns, rows] < np.iinfo(np.int32).max
            if 2 * reached.sum() > len(places) or 2 * reached.sum() > len(left):
                found: Points = left[reached]
                return found
            reached[0] = True  # Ensures progress: a place whose own node is not free reaches nothing.
            left = left[~reached]
        return left


def lattice(ground: ClearanceRaster, section: Section) -> Points:
    """Return the lattice points on open ground, (n, 2) of (x, z)."""
    x0, z0, x1, z1 = section.bounds
    xs, zs = (np.arange(np.ceil(low - LATTICE), high - LATTICE) + LATTICE for low, high in ((x0, x1), (z0, z1)))
    places: Points = np.stack(np.meshgrid(xs, zs, indexing="ij"), axis=-1).reshape(-1, 2)
    clear = np.array(
        [ground.clear_at(x, z) >= max(MIN_CLEARANCE, STEP_CLEARANCE / 1000.0) for x, z in places.tolist()], dtype=bool
    )
    return places[clear & (ground.solids.distance(places) >= MIN_CLEARANCE)]


def _turns_first(actions: Sequence[Action]) -> int:
    """Return the number of turns before the first step, at most that of turning around."""
    first = actions.index(Action.FORWARD) if Action.FORWARD in actions else len(actions)
    return min(first, len(FIRST_TURNS_KEPT[0]) - 1)


def draw_length(random: Random) -> int:
    """Return a random number of points of a path."""
    ((first, end, _),) = random.choices(LENGTHS, [weight for _, _, weight in LENGTHS])
    return random.randrange(first, end)


def follow_actions(start: Pose, actions: list[Action]) -> tuple[tuple[tuple[float, float], ...], Pose]:
    """Return the distinct positions of unobstructed actions, rounded to 1e-6 units, and the exact final pose."""
    path, pose = [(start.x, start.z)], start
    for action in actions:
        pose = moved(pose, action)
        if action is Action.FORWARD:
            path.append((round(pose.x, 6), round(pose.z, 6)))
    return tuple(path), pose
