"""What a walk costs on the ground that the agent has seen."""

import math

import numpy as np
import numpy.typing as npt
from scipy.ndimage import distance_transform_edt
from scipy.sparse.csgraph import dijkstra

from arramon_agents.mapping.cell_graph import cell_graph
from arramon_agents.mapping.ground_map import CELL, SIDE, GroundMap
from arramon_agents.mapping.walk_costs import clearance_of, step_costs

MARGIN = 12
"""Cells around the seen ground that also count."""

MIN_CLEARANCE = 0.36
"""Distance in units from everything solid that a walk keeps always."""

UNSEEN_COST, SEEN_WITHIN = 2.0, 0.5
"""Extra cost of a unit of unseen ground, and how far from seen ground others count as seen, in units."""

OBJECT_CELLS = 5
"""Cells on each side of an object that do not block the way to it."""

SHARES = (0.25, 0.5, 0.75, 1.0)
"""Parts of a step after which its place must be open."""


class KnownGround:
    """Costs of the part of a map that has been seen. Its cells are numbered row by row.

    Args:
        ground: the agent's map, on which some free ground has been seen.
    """

    def __init__(self, ground: GroundMap) -> None:
        solid, free, _ = ground.layers()
        rows, columns = np.nonzero(free)
        self._first = max(int(rows.min()) - MARGIN, 0), max(int(columns.min()) - MARGIN, 0)
        window = (
            slice(self._first[0], min(int(rows.max()) + MARGIN + 1, SIDE)),
            slice(self._first[1], min(int(columns.max()) + MARGIN + 1, SIDE)),
        )
        clearance = clearance_of(solid[window])
        is_seen = distance_transform_edt(~free[window]) * CELL <= SEEN_WITHIN
        self._costs = step_costs(clearance) + np.where(is_seen, 0.0, UNSEEN_COST)
        self._open: npt.NDArray[np.bool_] = clearance >= MIN_CLEARANCE
        self._cost_list: list[float] = self._costs.ravel().tolist()
        self._open_list: list[bool] = self._open.ravel().tolist()

    def cell(self, x: float, z: float) -> int | None:
        """Return the number of the cell at a place; None if it is outside."""
        rows, columns = self._costs.shape
        row = math.floor(x / CELL + SIDE / 2) - self._first[0]
        column = math.floor(z / CELL + SIDE / 2) - self._first[1]
        return row * columns + column if 0 <= row < rows and 0 <= column < columns else None

    def step_cost(self, x: float, z: float, dx: float, dz: float) -> float | None:
        """Return the cost of a step from (x, z) by (dx, dz); None if it is blocked."""
        cell = None
        for share in SHARES:
            cell = self.cell(x + share * dx, z + share * dz)
            if cell is None or not self._open_list[cell]:
                return None
        assert cell is not None
        return self._cost_list[cell]

    def costs_to(self, place: tuple[float, float]) -> list[float]:
        """Return the cost of the cheapest way from each cell to a place, by number; infinite where there is none."""
        end = self.cell(*place)
        if end is None:
            return [math.inf] * len(self._cost_list)
        is_open = self._open.copy()
        row, column = divmod(end, is_open.shape[1])
        reach = OBJECT_CELLS
        is_open[max(row - reach, 0) : row + reach + 1, max(column - reach, 0) : column + reach + 1] = True
        left: list[float] = dijkstra(cell_graph(is_open, self._costs, CELL), directed=False, indices=end).tolist()
        return left
