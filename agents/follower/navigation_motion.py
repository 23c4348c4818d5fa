"""A* over the agent's motion on its own map: unit steps at multiples of 30 degrees from its first heading."""

import math
from collections.abc import Callable
from heapq import heappop, heappush
from itertools import pairwise

from agents.follower.map import CELL, SIDE, Map
from arramon_client.agent import Action

HEADINGS = 12
TURN = 2.0 * math.pi / HEADINGS
STEPS = tuple((math.sin(TURN * i), math.cos(TURN * i)) for i in range(HEADINGS))

TURN_COST = 0.12
UNKNOWN_COST = 0.6
"""Additional cost of a step that ends on unknown ground."""

RESOLUTION = 0.5
"""Side of the search's squares, in units: places in one square count as one."""

HEURISTIC_WEIGHT = 1.15
"""Weight of the heuristic, the remaining distance (weighted A*)."""

MAX_EXPANDED = 350
"""Number of places expanded before the search returns the path to the nearest place found."""

TURNED = tuple(sorted(range(HEADINGS), key=lambda i: min(i, HEADINGS - i)))
AHEAD_TURNED = tuple(i for i in TURNED if min(i, HEADINGS - i) <= 3)

Pose = tuple[float, float, int]
"""(x, z) in the agent's own frame, and the heading in multiples of 30 degrees clockwise from its first heading."""


def can_step(ground: Map, x: float, z: float, heading: int) -> bool:
    """Return whether a step from (x, z) is free as far as is known."""
    sin, cos = STEPS[heading]
    blocked = ground.blocked
    half = SIDE / 2
    # The agent may be closer to obstacles than its map allows, so a blocked cell right beside it is ignored.
    for share in (0.5, 0.75, 1.0, 0.25):
        row, column = int((x + share * sin) / CELL + half), int((z + share * cos) / CELL + half)
        if not (0 <= row < SIDE and 0 <= column < SIDE):
            return False
        if blocked[row * SIDE + column]:
            return share == 0.25 and bool(blocked[int(x / CELL + half) * SIDE + int(z / CELL + half)])
    return True


def find_path(
    ground: Map,
    start: Pose,
    goal: tuple[float, float],
    radius: float,
    is_there: Callable[[float, float, int], bool] | None = None,
    closed_steps: frozenset[tuple[int, int, int]] = frozenset(),
) -> list[Action]:
    """Return the actions to the goal, or to the nearest place found; empty if the agent is already there.

    Args:
        ground: the agent's map.
        start: the agent's pose.
        goal: (x, z) in the agent's own frame.
        radius: distance to the goal that counts as reached, in units.
        is_there: further condition on the last pose (x, z, heading).
        closed_steps: `step_key`s of steps that turned out to be blocked.
    """
    free, half = ground.free, SIDE / 2
    goal_x, goal_z = goal
    nodes: list[tuple[float, float, int, int]] = [(*start, -1)]
    costs = [0.0]
    distance = math.hypot(goal_x - start[0], goal_z - start[1])
    queue = [(distance * HEURISTIC_WEIGHT, 0)]
    closed: set[tuple[int, int]] = set()
    best, best_left = 0, distance
    while queue and len(closed) < MAX_EXPANDED:
        _, number = heappop(queue)
        x, z, heading, _ = nodes[number]
        key = round(x / RESOLUTION), round(z / RESOLUTION)
        if key in closed:
            continue
        closed.add(key)
        left = math.hypot(goal_x - x, goal_z - z)
        if left <= radius:
            for turned in AHEAD_TURNED if is_there else (0,):
                if is_there is None or is_there(x, z, (heading + turned) % HEADINGS):
                    return _actions(nodes, number, (heading + turned) % HEADINGS)
        if left < best_left - 0.3:
            best, best_left = number, left
        for turned in TURNED if number == 0 else AHEAD_TURNED:
            new = (heading + turned) % HEADINGS
            if not can_step(ground, x, z, new) or (closed_steps and step_key(x, z, new) in closed_steps):
                continue
            nx, nz = x + STEPS[new][0], z + STEPS[new][1]
            if (round(nx / RESOLUTION), round(nz / RESOLUTION)) in closed:
                continue
            cost = costs[number] + 1.0 + TURN_COST * min(turned, HEADINGS - turned)
            if not free[int(nx / CELL + half) * SIDE + int(nz / CELL + half)]:
                cost += UNKNOWN_COST
            nodes.append((nx, nz, new, number))
            costs.append(cost)
            heappush(queue, (cost + HEURISTIC_WEIGHT * math.hypot(goal_x - nx, goal_z - nz), len(nodes) - 1))
    return _actions(nodes, best, nodes[best][2])


def turns(heading: int, to: int) -> list[Action]:
    """Return the shortest sequence of turns from one heading to another."""
    difference = (to - heading) % HEADINGS
    if difference <= HEADINGS // 2:
        return [Action.RIGHT] * difference
    return [Action.LEFT] * (HEADINGS - difference)


def step_key(x: float, z: float, heading: int) -> tuple[int, int, int]:
    """Return a key of the step that starts at a pose, robust to rounding."""
    return round(x * 10), round(z * 10), heading


def _actions(nodes: list[tuple[float, float, int, int]], number: int, last: int) -> list[Action]:
    """Return the actions from the first node to node `number`, and from its heading to the heading `last`."""
    headings = [nodes[number][2]]
    while nodes[number][3] >= 0:
        number = nodes[number][3]
        headings.append(nodes[number][2])
    headings.reverse()
    actions: list[Action] = []
    for before, after in pairwise(headings):
        actions += [*turns(before, after), Action.FORWARD]
    return actions + turns(headings[-1], last)
