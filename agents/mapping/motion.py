"""Path planning (A*) on the agent's own map, with unit steps and turns of 30 degrees."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise

from arramon_agents.mapping.ground_map import CELL, SIDE, GroundMap
from arramon_agents.mapping.search import a_star
from arramon_client.agent import Action
from arramon_client.world import HEADINGS

TURN = 2.0 * math.pi / HEADINGS
STEPS = tuple((math.sin(TURN * i), math.cos(TURN * i)) for i in range(HEADINGS))

TURN_COST = 0.12
UNKNOWN_COST = 0.6
"""Additional cost of a step that ends on unknown ground."""

RESOLUTION = 0.5
"""Side of the squares in which the search merges places, in units."""

HEURISTIC_WEIGHT = 1.15
"""Weight of the heuristic, the remaining distance (weighted A*)."""

MAX_EXPANDED = 350
"""Number of places expanded before the search returns the path to the nearest place found."""

MARGIN = 0.3
"""Minimum decrease of the distance to the goal for a place to replace the nearest one found, in units."""

TURNED = tuple(sorted(range(HEADINGS), key=lambda i: min(i, HEADINGS - i)))
AHEAD_TURNED = tuple(i for i in TURNED if min(i, HEADINGS - i) <= 3)

Pose = tuple[float, float, int]
"""(x, z) in the agent's own frame, and the heading in multiples of 30 degrees clockwise from its first heading."""


def can_step(ground: GroundMap, x: float, z: float, heading: int) -> bool:
    """Return whether a step from (x, z) is not known to be blocked."""
    sin, cos = STEPS[heading]
    blocked = ground.blocked
    half = SIDE / 2
    # The agent may be closer to obstacles than its map allows, so ignore a blocked cell right next to it.
    for share in (0.5, 0.75, 1.0, 0.25):
        row, column = int((x + share * sin) / CELL + half), int((z + share * cos) / CELL + half)
        if not (0 <= row < SIDE and 0 <= column < SIDE):
            return False
        if blocked[row * SIDE + column]:
            return share == 0.25 and bool(blocked[int(x / CELL + half) * SIDE + int(z / CELL + half)])
    return True


@dataclass(frozen=True)
class _MapSearch:
    """Search problem: walk to a goal on the agent's map; arguments as for `find_path`."""

    ground: GroundMap
    start: Pose
    goal: tuple[float, float]
    radius: float
    is_there: Callable[[float, float, int], bool] | None
    closed_steps: frozenset[tuple[int, int, int]]

    def key(self, pose: Pose) -> tuple[int, int]:
        """Return the square of a pose, regardless of its heading."""
        return round(pose[0] / RESOLUTION), round(pose[1] / RESOLUTION)

    def remaining(self, pose: Pose) -> float:
        """Return the weighted distance to the goal."""
        return HEURISTIC_WEIGHT * math.hypot(self.goal[0] - pose[0], self.goal[1] - pose[1])

    def is_goal(self, pose: Pose) -> bool:
        """Return whether the agent has arrived at a pose, after a turn if needed."""
        return self.last_heading(pose) is not None

    def last_heading(self, pose: Pose) -> int | None:
        """Return the nearest heading with which the goal is reached at a pose; None if there is none."""
        x, z, heading = pose
        if math.hypot(self.goal[0] - x, self.goal[1] - z) > self.radius:
            return None
        for turned in AHEAD_TURNED if self.is_there else (0,):
            if self.is_there is None or self.is_there(x, z, (heading + turned) % HEADINGS):
                return (heading + turned) % HEADINGS
        return None

    def successors(self, pose: Pose) -> Iterator[tuple[Pose, float]]:
        """Yield the poses one step away that are not known to be blocked."""
        x, z, heading = pose
        free, half = self.ground.free, SIDE / 2
        for turned in TURNED if pose is self.start else AHEAD_TURNED:
            new = (heading + turned) % HEADINGS
            if not can_step(self.ground, x, z, new) or (self.closed_steps and step_key(x, z, new) in self.closed_steps):
                continue
            nx, nz = x + STEPS[new][0], z + STEPS[new][1]
            cost = 1.0 + TURN_COST * min(turned, HEADINGS - turned)
            if not free[int(nx / CELL + half) * SIDE + int(nz / CELL + half)]:
                cost += UNKNOWN_COST
            yield (nx, nz, new), cost


def find_path(
    ground: GroundMap,
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
    motion = _MapSearch(ground, start, goal, radius, is_there, closed_steps)
    poses = a_star(motion, start, MAX_EXPANDED, margin=MARGIN * HEURISTIC_WEIGHT).states
    actions: list[Action] = []
    for before, after in pairwise(poses):
        actions += [*turns(before[2], after[2]), Action.FORWARD]
    last = motion.last_heading(poses[-1])
    return actions if last is None else actions + turns(poses[-1][2], last)


def turns(heading: int, to: int) -> list[Action]:
    """Return the shortest sequence of turns from one heading to another."""
    difference = (to - heading) % HEADINGS
    if difference <= HEADINGS // 2:
        return [Action.RIGHT] * difference
    return [Action.LEFT] * (HEADINGS - difference)


def step_key(x: float, z: float, heading: int) -> tuple[int, int, int]:
    """Return a key of the step that starts at a pose, robust to rounding."""
    return round(x * 10), round(z * 10), heading
