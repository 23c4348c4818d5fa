"""Motion planning (A*) with unit steps and turns of 30 degrees, to a pose with the target in reach."""

import math
from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import NamedTuple

from arramon_agents.mapping.search import a_star
from arramon_agents.shortest_path.clearance_map import ClearanceMap, Place
from arramon_agents.shortest_path.route import GuideRoute, Router
from arramon_client.agent import Action
from arramon_client.world import HEADINGS, REACH_SIDE, TURN

TURN_COST = 0.1
"""Cost of a turn; a step costs 1. Of two equally long paths, the one with fewer turns is preferred."""

STRAYING_COST = 1.0
"""Additional cost of a step, times the squared distance of its end from the route."""

RESOLUTION = 0.25
"""Side of the squares in which the search merges poses with the same heading, in units."""

REACH_FROM, REACH_TO = 0.9, 2.0
"""Range of distances of the target ahead at the goal, in units; the release's paths end within 2 units of it."""

MAX_EXPANDED = 200_000
"""Maximum number of expanded poses."""


class CityPose(NamedTuple):
    """A pose in the city: x and z in units, heading in degrees clockwise from +z."""

    x: float
    z: float
    heading: float


class _Node(NamedTuple):
    """A pose: x and z in units, and the number of turns of 30 degrees clockwise since the start, in [0, 12)."""

    x: float
    z: float
    turned: int


class _RouteSearch:
    """Search problem: walk along a route until the target is in reach; arguments as for `plan`."""

    def __init__(
        self,
        ground: ClearanceMap,
        router: Router,
        route: GuideRoute,
        start: CityPose,
        target: Place,
        is_open: Callable[[CityPose, CityPose], bool],
    ) -> None:
        self._ground, self._router, self._route, self._target, self._is_open = ground, router, route, target, is_open
        self._first_heading = start.heading
        angles = [math.radians(start.heading + TURN * i) for i in range(HEADINGS)]
        self._steps = [(math.sin(angle), math.cos(angle)) for angle in angles]

    def key(self, node: _Node) -> tuple[int, int, int]:
        """Return the square and heading of a node."""
        return round(node.x / RESOLUTION), round(node.z / RESOLUTION), node.turned

    def remaining(self, node: _Node) -> float:
        """Return the remaining cost of the route, as heuristic."""
        return self._router.remaining_cost(self._route, node.x, node.z)

    def is_goal(self, node: _Node) -> bool:
        """Return whether the target is in reach."""
        sin, cos = self._steps[node.turned]
        dx, dz = self._target[0] - node.x, self._target[1] - node.z
        if not REACH_FROM <= dx * sin + dz * cos <= REACH_TO:
            return False
        return abs(dx * cos - dz * sin) <= REACH_SIDE and math.hypot(dx, dz) <= REACH_TO

    def successors(self, node: _Node) -> Iterator[tuple[_Node, float]]:
        """Yield the poses after each action."""
        yield _Node(node.x, node.z, (node.turned - 1) % HEADINGS), TURN_COST
        yield _Node(node.x, node.z, (node.turned + 1) % HEADINGS), TURN_COST
        sin, cos = self._steps[node.turned]
        x, z = node.x + sin, node.z + cos
        heading = (self._first_heading + TURN * node.turned) % 360.0
        free = self._ground.is_free((node.x, node.z), (x, z))
        if free and self._is_open(CityPose(node.x, node.z, heading), CityPose(x, z, heading)):
            yield _Node(x, z, node.turned), 1.0 + STRAYING_COST * self._route.distance(x, z) ** 2


def plan(
    ground: ClearanceMap,
    router: Router,
    route: GuideRoute,
    start: CityPose,
    target: Place,
    is_open: Callable[[CityPose, CityPose], bool],
) -> list[Action] | None:
    """Return the actions to a pose with the target in reach, without INTERACT; None if none are found.

    Args:
        ground: clearance map of the section.
        router: router on the clearance map.
        route: route to the target, which the actions follow as closely as the motion allows.
        start: the agent's pose.
        target: (x, z) of the target.
        is_open: returns whether a step from one pose to another is allowed.
    """
    motion = _RouteSearch(ground, router, route, start, target, is_open)
    nodes, reached = a_star(motion, _Node(start.x, start.z, 0), MAX_EXPANDED)
    return [_action(before, after) for before, after in pairwise(nodes)] if reached else None


def _action(before: _Node, after: _Node) -> Action:
    turned = (after.turned - before.turned) % HEADINGS
    return {0: Action.FORWARD, 1: Action.RIGHT, HEADINGS - 1: Action.LEFT}[turned]
