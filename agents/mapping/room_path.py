"""Shortest paths in the assembly room to a pose that faces the target cell."""

from collections.abc import Collection
from heapq import heappop, heappush
from typing import NamedTuple

from arramon_client.agent import Action
from arramon_client.world import COLUMNS, ROWS

AHEAD = ((0, 1), (1, 0), (0, -1), (-1, 0))
"""Offset (columns, rows) of the cell ahead, by heading in quarter turns clockwise from +row."""

Cell = tuple[int, int]


class RoomPose(NamedTuple):
    """The agent's pose in the room: cell, and heading in quarter turns clockwise from +row."""

    column: int
    row: int
    quarter: int

    @property
    def ahead(self) -> Cell:
        """The cell ahead, which may be outside the room."""
        columns, rows = AHEAD[self.quarter]
        return self.column + columns, self.row + rows


def plan(start: RoomPose, target: Cell, blocked: Collection[Cell]) -> list[Action] | None:
    """Return the actions to a pose whose cell ahead is the target, without INTERACT; None if it cannot be reached.

    Args:
        start: the agent's pose.
        target: (column, row) of the target cell.
        blocked: cells that cannot be entered.
    """
    queue: list[tuple[int, RoomPose, tuple[Action, ...]]] = [(0, start, ())]
    closed: set[RoomPose] = set()
    while queue:
        cost, stand, actions = heappop(queue)
        if stand.ahead == target:
            return list(actions)
        if stand in closed:
            continue
        closed.add(stand)
        for turns, action in ((1, Action.RIGHT), (-1, Action.LEFT)):
            turned = RoomPose(stand.column, stand.row, (stand.quarter + turns) % 4)
            heappush(queue, (cost + 3, turned, (*actions, *([action] * 3))))
        column, row = stand.ahead
        if 0 <= column < COLUMNS and 0 <= row < ROWS and (column, row) not in blocked:
            heappush(queue, (cost + 1, RoomPose(column, row, stand.quarter), (*actions, Action.FORWARD)))
    return None


def quarter_and_turns(heading: float) -> tuple[int, list[Action]]:
    """Return the quarter turn nearest to a heading in degrees, and the actions that turn to it."""
    quarter = round(heading / 90.0)
    turns = round((quarter * 90.0 - heading) / 30.0)
    return quarter % 4, [Action.RIGHT if turns > 0 else Action.LEFT] * abs(turns)
