"""The ground truth of a navigation: A* in the agent's own motion, along the middle of streets, with few turns."""

import math
from dataclasses import dataclass

import numpy as np

from server.episodes.generate.ground import CELL, FAR, Ground, Numbers
from server.episodes.generate.search import Heap, spread, walk
from server.sim.geometry import STEP, TURN, Pose
from server.sim.rules import REACH_SIDE, Action

NEED = 420
"""Clearance that a sample of a step needs, in thousandths of a unit: between samples (an eighth of a unit apart, in
cells of as much) the agent's disc of 250 then touches nothing."""

SIGHT = 160
"""The same of the way from the end to the target, over which the agent looks and nobody goes."""

COMFORT = 2000
"""Clearance that a way keeps where it can, in thousandths of a unit."""

DISCOMFORT = 900
"""What a unit of way counts more right at a wall, beside its 1000; less by the square of the distance, to COMFORT."""

TURN_COST = 350
"""What a turn of 30 degrees counts, beside a step's 1000."""

OBLIQUE_COST = 600
"""What a step counts more that goes 30 degrees off the street's direction; of the first 15 nothing, as headings are 30
apart and streets run as they like. People walk along streets and turn at corners."""

ASIDE_COST = 700
"""What a unit counts that the target is aside at the end: an agent that can faces what it picks up."""

REACH_FROM, REACH_TO = 0.97, 1.96
"""How far ahead the target is at the end, in units: as in the original."""

REACH_ASIDE = REACH_SIDE - 0.05
"""How far aside the target may be at the end, in units."""

LIMIT = 400_000
"""Poses that are looked at before a search gives up."""

HEADINGS = round(360.0 / TURN)


@dataclass(frozen=True, eq=False)
class Field:
    """What it takes to get to one place from all others.

    Attributes:
        cost: (node columns, node rows), thousandths of a step; 2**31 - 1 where there is no way.
        length: the same shape, thousandths of a unit along the cheapest way.
    """

    cost: Numbers
    length: Numbers


class Walker:
    """Finds ways over one ground. Its scratch memory is reused: it belongs to one thread.

    Args:
        ground: where.
    """

    def __init__(self, ground: Ground) -> None:
        self.ground = ground
        clear = np.arange(FAR + 1)
        lack = np.maximum(COMFORT - clear, 0)
        self._discomfort = (1000 + DISCOMFORT * lack * lack // COMFORT**2).astype(np.int32)
        self._oblique = OBLIQUE_COST * np.maximum(np.arange(46, dtype=np.int32) - 15, 0) // 15
        columns, rows = ground.nodes
        self._field_heap: Heap = np.empty(columns * rows * 16 + 1, np.int64)
        squares = tuple(math.ceil(count * CELL * 4) + 1 for count in ground.clearance.shape)
        self._best: Numbers = np.zeros((*squares, HEADINGS), np.int32)
        self._stamps: Numbers = np.zeros_like(self._best)
        self._stamp = 0
        self._x, self._z = np.empty(3 * LIMIT), np.empty(3 * LIMIT)
        self._facing, self._before, self._spent = (np.empty(3 * LIMIT, np.int32) for _ in range(3))
        self._heap: Heap = np.empty(3 * LIMIT + 1, np.int64)

    def field(self, x: float, z: float) -> Field:
        """The ways from all places to the node nearest to (x, z)."""
        cost: Numbers = np.empty(self.ground.nodes, np.int32)
        length: Numbers = np.empty(self.ground.nodes, np.int32)
        column, row = self.ground.node(x, z)
        spread(self.ground.clearance, self._discomfort, NEED, column, row, cost, length, self._field_heap)
        return Field(cost, length)

    def actions(self, start: Pose, target: tuple[float, float], field: Field) -> list[Action] | None:
        """The actions from `start` to where the target is in reach and in view, INTERACT not included.

        Args:
            start: a pose.
            target: its (x, z).
            field: the target's.

        Returns:
            None where there is no way.
        """
        angles = np.radians(start.heading + TURN * np.arange(HEADINGS))
        steps = np.round(STEP * np.stack([np.sin(angles), np.cos(angles)], axis=1), 9)
        directions = (np.round(start.heading + TURN * np.arange(HEADINGS)) % 90).astype(np.int32)
        goal = np.array([*target, REACH_FROM, REACH_TO, REACH_ASIDE, SIGHT])
        self._stamp += 1
        last = walk(
            self.ground.clearance, self._discomfort, self.ground.axes, directions, self._oblique,
            self.ground.left, self.ground.bottom, field.cost, steps, start.x, start.z, goal,
            NEED, TURN_COST, ASIDE_COST, LIMIT,
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
