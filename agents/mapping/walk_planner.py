"""Plans of walks on the agent's own map, by the rules of the expert whose walks are the ground truth.

The expert keeps to the middle of streets, walks along them or across them, and turns little. A walk that is as long but
keeps to one side, or cuts across, is farther from the ground truth.
"""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from arramon_agents.mapping.body import AgentBody
from arramon_agents.mapping.ground_map import CELL, SIDE
from arramon_agents.mapping.motion import STEPS
from arramon_agents.mapping.walk_costs import TURN_COST, clearance_of, step_costs
from arramon_agents.mapping.walk_kernel import CIRCLE, LINE, PICK_UP, PICK_UP_TO, search
from arramon_client.agent import Action
from arramon_client.world import HEADINGS

OBLIQUE_COST = 0.3
"""Extra cost of a step that is not along the streets or across them: half of the expert's, since the agent's map does
not always show which way the streets run."""

OFFSET_COST = 0.7
"""Cost of each unit of the object's sideways offset at a pick-up."""

UNSEEN_COST = 0.6
"""Extra cost of a step that ends on unseen ground."""

MARGIN = 8.0
"""Distance around start and goal beyond which a walk does not go, in units."""

MAX_EXPANDED = 20_000
"""Number of poses that are expanded before the search returns the walk to the nearest place found."""

Floats = npt.NDArray[np.float64]

_STEPS = np.array(STEPS)
_NONE: Floats = np.empty((0, 2))


@dataclass(frozen=True, slots=True)
class Circle:
    """Goal: be within `radius` units of (x, z)."""

    x: float
    z: float
    radius: float


@dataclass(frozen=True, slots=True)
class Line:
    """Goal: cross the line through (x, z) at right angles to a course, in radians, and stay near the course meanwhile.

    Attributes:
        aside: maximum distance from the straight line along the course through (x, z), in units.
    """

    x: float
    z: float
    course: float
    aside: float


@dataclass(frozen=True, slots=True)
class PickUp:
    """Goal: be where a pick-up takes an object and no other.

    Attributes:
        x, z: the object's place.
        others: (n, 2) of (x, z), places of the other objects.
    """

    x: float
    z: float
    others: Floats


Goal = Circle | Line | PickUp


def plan_walk(body: AgentBody, goal: Goal) -> list[Action]:
    """Return the actions to a goal, or to the nearest place found; empty if the agent is already there."""
    costs, first_row, first_column = _costs_around(body, goal)
    closed = np.array(sorted(body.closed_steps), np.int64).reshape(-1, 3)
    kind, numbers, others = _encode(goal)
    headings, is_reached = search(
        np.frombuffer(body.ground.blocked, np.uint8), costs, first_row, first_column, _STEPS, closed,
        body.x, body.z, body.heading, body.street_axis, TURN_COST, OBLIQUE_COST, OFFSET_COST,
        kind, numbers, others, MAX_EXPANDED,
    )  # fmt: skip
    moves = {0: Action.FORWARD, 1: Action.RIGHT, HEADINGS - 1: Action.LEFT}
    actions = [moves[(after - before) % HEADINGS] for before, after in pairwise(headings.tolist())]
    while actions and not is_reached and actions[-1] is not Action.FORWARD:
        actions.pop()
    return actions


def _encode(goal: Goal) -> tuple[int, Floats, Floats]:
    """Return a goal as `walk_kernel.search` takes it: kind, numbers, and other objects."""
    if isinstance(goal, Line):
        numbers = goal.x, goal.z, math.sin(goal.course), math.cos(goal.course), goal.aside
        return LINE, np.array(numbers), _NONE
    if isinstance(goal, PickUp):
        return PICK_UP, np.array((goal.x, goal.z, PICK_UP_TO)), goal.others
    return CIRCLE, np.array((goal.x, goal.z, goal.radius)), _NONE


def _costs_around(body: AgentBody, goal: Goal) -> tuple[Floats, int, int]:
    """Return the cost of a step to each cell of the map around the agent and its goal, and the row and column of the
    first one."""
    rows, columns = (
        slice(max(int((min(ends) - MARGIN) / CELL) + SIDE // 2, 0), int((max(ends) + MARGIN) / CELL) + SIDE // 2 + 1)
        for ends in ((body.x, goal.x), (body.z, goal.z))
    )
    solid, free, _ = body.ground.layers()
    costs = step_costs(clearance_of(solid[rows, columns])) + np.where(free[rows, columns], 0.0, UNSEEN_COST)
    return costs, rows.start, columns.start
