"""A* in the agent's own motion: unit steps and turns of 30 degrees, from a pose to one that has the target in reach."""

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
"""What a turn counts, beside a step's 1: of two ways of one length the one with fewer turns is taken."""

STRAYING_COST = 1.0
"""What a step counts more for each squared unit that it ends off the route."""

GRAIN = 0.25
"""Two places in one square of this side, in units, with one heading, are one to the search."""

REACH_SIDE, REACH_FROM, REACH_TO = 0.5, 0.9, 2.0
"""Where the target may lie in the end, in units to the side and ahead; the release's paths end within 2 units of it."""

LIMIT = 200_000
"""Poses that are looked at before the search gives up."""


class Walk(NamedTuple):
    """A pose in the city: units, and degrees clockwise from +z."""

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
    """The actions from `start` to where the target is in reach, INTERACT not included; None where none are found.

    Args:
        ground: what is free.
        router: of the ground.
        route: to the target, which the actions follow as well as the motion can.
        start: a pose.
        target: its (x, z).
        is_open: whether a step from one pose to another is allowed, beside being free.
    """
    angles = [math.radians(start.heading + TURN * i) for i in range(HEADINGS)]
    steps = [(math.sin(angle), math.cos(angle)) for angle in angles]
    first = _Node(start.x, start.z, 0, 0.0, None, None)
    queue: list[tuple[float, int, _Node]] = [(router.left(route, start.x, start.z), 0, first)]
    closed: set[tuple[int, int, int]] = set()
    pushed = 0
    while queue and len(closed) < LIMIT:
        _, _, node = heappop(queue)
        if _in_reach(node, steps[node.turned], target):
            return _actions(node)
        key = round(node.x / GRAIN), round(node.z / GRAIN), node.turned
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
            if (round(new.x / GRAIN), round(new.z / GRAIN), new.turned) not in closed:
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
