"""The shortest way in the assembly room: to a cell next to the target's, facing it."""

from collections.abc import Collection
from heapq import heappop, heappush
from typing import NamedTuple

from arramon_client.agent import Action

COLUMNS, ROWS = 5, 4

AHEAD = ((0, 1), (1, 0), (0, -1), (-1, 0))
"""The (columns, rows) of one cell ahead, by quarters turned clockwise from +row."""

Cell = tuple[int, int]


class Stand(NamedTuple):
    """Where the agent stands: cell, and quarters turned clockwise from +row."""

    column: int
    row: int
    quarter: int

    @property
    def ahead(self) -> Cell:
        """The cell in front, which may be outside."""
        columns, rows = AHEAD[self.quarter]
        return self.column + columns, self.row + rows


def plan(start: Stand, target: Cell, blocked: Collection[Cell]) -> list[Action] | None:
    """The actions to a cell from which the target's is the one ahead, INTERACT not included; None where there are none.

    Args:
        start: where the agent stands.
        target: (column, row).
        blocked: cells that cannot be entered.
    """
    queue: list[tuple[int, Stand, tuple[Action, ...]]] = [(0, start, ())]
    closed: set[Stand] = set()
    while queue:
        cost, stand, actions = heappop(queue)
        if stand.ahead == target:
            return list(actions)
        if stand in closed:
            continue
        closed.add(stand)
        for turns, action in ((1, Action.RIGHT), (-1, Action.LEFT)):
            turned = Stand(stand.column, stand.row, (stand.quarter + turns) % 4)
            heappush(queue, (cost + 3, turned, (*actions, *([action] * 3))))
        column, row = stand.ahead
        if 0 <= column < COLUMNS and 0 <= row < ROWS and (column, row) not in blocked:
            heappush(queue, (cost + 1, Stand(column, row, stand.quarter), (*actions, Action.FORWARD)))
    return None


def quarter_of(heading: float) -> tuple[int, list[Action]]:
    """The nearest quarter turn to a heading in degrees, and the turns that lead to it."""
    quarter = round(heading / 90.0)
    turns = round((quarter * 90.0 - heading) / 30.0)
    return quarter % 4, [Action.RIGHT if turns > 0 else Action.LEFT] * abs(turns)
