"""A* over the agent's motion, unit steps and turns of 30 degrees, from a pose to one with the target in reach."""

import math
from collections.abc import Callable
from heapq import heappop, heappush
from typing import NamedTuple

from agents.shortest_path.ground import Ground, Place
from agents.shortest_path.route import Route, Router
from arramon_client.agent import Action

HEADINGS = 12
TURN = 360.0 / HEADINGS

TURN_COST = 0.1
"""Cost of a turn; a step costs 1. Of two equally long paths, the one with fewer turns is preferred."""

STRAYING_COST = 1.0
"""Additional cost of a step for each squared unit between its end and the route."""

RESOLUTION = 0.25
"""Side of the search's squares, in units: poses in one square with the same heading count as one."""

REACH_SIDE, REACH_FROM, REACH_TO = 0.5, 0.9, 2.0
"""Range of the target at the goal, in units to the side and ahead; the release's paths end within 2 units of it."""

MAX_EXPANDED = 200_000
"""Number of poses expanded before the search gives up."""


class Walk(NamedTuple):
    """A pose in the city: x and z in units, heading in degrees clockwise from +z."""

    x: float
    z: float
    heading: float


class _Node(NamedTuple):
    x: float
    z: float
    turned: int
    cost: float
    action: Action | None
    before: "_Node | None"


def plan(
    ground: Ground, router: Router, route: Route, start: Walk, target: Place, is_open: Callable[[Walk, Walk], bool]
) -> list[Action] | None:
    """Return the actions to a pose with the target in reach, without INTERACT; None if none are found.

    Args:
        ground: the free ground.
        router: router over the ground.
        route: route to the target, which the actions follow as closely as the motion allows.
        start: the agent's pose.
        target: (x, z) of the target.
        is_open: returns whether a free step from one pose to another is allowed.
    """
    angles = [math.radians(start.heading + TURN * i) for i in range(HEADINGS)]
    steps = [(math.sin(angle), math.cos(angle)) for angle in angles]
    first = _Node(start.x, start.z, 0, 0.0, None, None)
    queue: list[tuple[float, int, _Node]] = [(router.left(route, start.x, start.z), 0, first)]
    closed: set[tuple[int, int, int]] = set()
    pushed = 0
    while queue and len(closed) < MAX_EXPANDED:
        _, _, node = heappop(queue)
        if _in_reach(node, steps[node.turned], target):
            return _actions(node)
        key = round(node.x / RESOLUTION), round(node.z / RESOLUTION), node.turned
        if key in closed:
            continue
        closed.add(key)
        sin, cos = steps[node.turned]
        x, z = node.x + sin, node.z + cos
        following = [
            _Node(node.x, node.z, (node.turned - 1) % HEADINGS, node.cost + TURN_COST, Action.LEFT, node),
            _Node(node.x, node.z, (node.turned + 1) % HEADINGS, node.cost + TURN_COST, Action.RIGHT, node),
        ]
        heading = (start.heading + TURN * node.turned) % 360.0
        if ground.is_free((node.x, node.z), (x, z)) and is_open(Walk(node.x, node.z, heading), Walk(x, z, heading)):
            cost = node.cost + 1.0 + STRAYING_COST * route.distance(x, z) ** 2
            following.append(_Node(x, z, node.turned, cost, Action.FORWARD, node))
        for new in following:
            if (round(new.x / RESOLUTION), round(new.z / RESOLUTION), new.turned) not in closed:
                pushed += 1
                heappush(queue, (new.cost + router.left(route, new.x, new.z), pushed, new))
    return None


def _in_reach(node: _Node, ahead: tuple[float, float], target: Place) -> bool:
    sin, cos = ahead
    dx, dz = target[0] - node.x, target[1] - node.z
    if not REACH_FROM <= dx * sin + dz * cos <= REACH_TO:
        return False
    return abs(dx * cos - dz * sin) <= REACH_SIDE and math.hypot(dx, dz) <= REACH_TO


def _actions(node: _Node) -> list[Action]:
    actions: list[Action] = []
    at: _Node | None = node
    while at is not None and at.action is not None:
        actions.append(at.action)
        at = at.before
    return actions[::-1]
