"""Planning of ground-truth paths by A* over the agent's actions, along the middle of streets and with few turns."""

import math
from dataclasses import dataclass

import numpy as np

from arramon_client.world import HEADINGS, REACH_SIDE, STEP, TURN, Action
from arramon_dataset.generation.clearance_raster import CELL, FAR, ClearanceRaster, Numbers
from arramon_dataset.generation.search import Heap, a_star, dijkstra
from arramon_server.sim.geometry import Pose

STEP_CLEARANCE = 420
"""Minimum clearance at each sample of a step, in thousandths of a unit. Samples are an eighth of a unit apart, in cells
of the same size, so that the agent's disc of radius 250 touches nothing between them either."""

SIGHT_CLEARANCE = 160
"""Minimum clearance along the line of sight to the target, in thousandths of a unit."""

PREFERRED_CLEARANCE = 2000
"""Clearance that paths keep where possible, in thousandths of a unit."""

WALL_COST = 900
"""Extra cost of a unit of path at a wall, on top of 1000; it falls quadratically to 0 at PREFERRED_CLEARANCE."""

TURN_COST = 110
"""Cost of a turn of 30 degrees, where a step costs 1000."""

OBLIQUE_COST = 600
"""Extra cost of a step 30 degrees off the street's direction; 0 up to 15 degrees, as headings are 30 degrees apart and
streets run in any direction. People walk along streets and turn at corners."""

OFFSET_COST = 700
"""Cost of each unit of the target's sideways offset at the end: the agent should face what it picks up."""

REACH_FROM, REACH_TO = 0.97, 1.96
"""Range of the target's distance ahead at the end, in units, as in the original."""

REACH_OFFSET = REACH_SIDE - 0.05
"""Maximum sideways offset of the target at the end, in units."""

MAX_EXPANDED = 400_000
"""Maximum number of poses that a search expands."""


@dataclass(frozen=True, eq=False)
class CostField:
    """Costs and lengths of the cheapest paths from all nodes to one place.

    Attributes:
        cost: (node columns, node rows), thousandths of a step; 2**31 - 1 where unreachable.
        length: the same shape, thousandths of a unit along the cheapest path.
    """

    cost: Numbers
    length: Numbers


class PathPlanner:
    """Plans paths in one section. Reuses its buffers, so it is not thread-safe.

    Args:
        ground: clearance raster of the section.
    """

    def __init__(self, ground: ClearanceRaster) -> None:
        self.ground = ground
        clear = np.arange(FAR + 1)
        lack = np.maximum(PREFERRED_CLEARANCE - clear, 0)
        self._discomfort = (1000 + WALL_COST * lack * lack // PREFERRED_CLEARANCE**2).astype(np.int32)
        self._oblique = OBLIQUE_COST * np.maximum(np.arange(46, dtype=np.int32) - 15, 0) // 15
        columns, rows = ground.nodes
        self._field_heap: Heap = np.empty(columns * rows * 16 + 1, np.int64)
        squares = tuple(math.ceil(count * CELL * 4) + 1 for count in ground.clearance.shape)
        self._best: Numbers = np.zeros((*squares, HEADINGS), np.int32)
        self._stamps: Numbers = np.zeros_like(self._best)
        self._stamp = 0
        self._x, self._z = np.empty(3 * MAX_EXPANDED), np.empty(3 * MAX_EXPANDED)
        self._facing, self._before, self._spent = (np.empty(3 * MAX_EXPANDED, np.int32) for _ in range(3))
        self._heap: Heap = np.empty(3 * MAX_EXPANDED + 1, np.int64)

    def field(self, x: float, z: float) -> CostField:
        """Return the cost field of the node nearest to (x, z)."""
        cost: Numbers = np.empty(self.ground.nodes, np.int32)
        length: Numbers = np.empty(self.ground.nodes, np.int32)
        column, row = self.ground.node(x, z)
        dijkstra(self.ground.clearance, self._discomfort, STEP_CLEARANCE, column, row, cost, length, self._field_heap)
        return CostField(cost, length)

    def actions(self, start: Pose, target: tuple[float, float], field: CostField) -> list[Action] | None:
        """Return the actions from `start` until the target is within reach and in view, without the final INTERACT.

        Args:
            start: pose before the first action.
            target: (x, z), in units.
            field: cost field of the target.

        Returns:
            None if there is no path.
        """
        angles = np.radians(start.heading + TURN * np.arange(HEADINGS))
        steps = np.round(STEP * np.stack([np.sin(angles), np.cos(angles)], axis=1), 9)
        directions = (np.round(start.heading + TURN * np.arange(HEADINGS)) % 90).astype(np.int32)
        goal = np.array([*target, REACH_FROM, REACH_TO, REACH_OFFSET, SIGHT_CLEARANCE])
        self._stamp += 1
        last = a_star(
            self.ground.clearance, self._discomfort, self.ground.axes, directions, self._oblique,
            self.ground.left, self.ground.bottom, field.cost, steps, start.x, start.z, goal,
            STEP_CLEARANCE, TURN_COST, OFFSET_COST, MAX_EXPANDED,
            self._best, self._stamps, self._stamp, self._x, self._z, self._facing, self._before, self._spent,
            self._heap,
        )  # fmt: skip
        return None if last < 0 else self._actions(int(self._before[last]))

    def _actions(self, node: int) -> list[Action]:
        actions: list[Action] = []
        while self._before[node] >= 0:
            earlier = int(self._before[node])
            turned = (self._facing[node] - self._facing[earlier]) % HEADINGS
            actions.append({0: Action.FORWARD, 1: Action.RIGHT, HEADINGS - 1: Action.LEFT}[int(turned)])
            node = earlier
        return actions[::-1]
