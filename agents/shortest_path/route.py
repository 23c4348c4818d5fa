"""Shortest routes on the clearance map (Dijkstra), which ignore the agent's motion and guide the motion planner."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt
from scipy.sparse.csgraph import dijkstra

from arramon_agents.mapping.cell_graph import cell_graph
from arramon_agents.shortest_path.clearance_map import CELL, ClearanceMap, Place, distance_to_segment

STRIDE = 2
"""Raster cells between two nodes."""

PREFERRED_CLEARANCE = 1.5
"""Clearance that a route keeps where possible, in units."""

CLEARANCE_PENALTY = 0.8
"""Relative increase of a route's cost per unit of missing clearance."""

SLACK = 0.05
"""Clearance that a straightened route may lose, in units."""


@dataclass(frozen=True)
class GuideRoute:
    """A route to a target.

    Attributes:
        corners: (x, z) of the corners, from the start to the target.
        left: (columns, rows) remaining cost to the target by node of the raster, in units of distance, more near
            walls; infinite where the target cannot be reached.
    """

    corners: tuple[Place, ...]
    left: npt.NDArray[np.float64]

    def distance(self, x: float, z: float) -> float:
        """Return the distance of a place from the route, in units."""
        return min(distance_to_segment(x, z, *a, *b) for a, b in pairwise(self.corners))


class Router:
    """Finds routes on the clearance map of a section by Dijkstra's algorithm.

    Args:
        ground: the clearance map.
    """

    def __init__(self, ground: ClearanceMap) -> None:
        self._ground = ground
        self._clearance = ground.clearance[::STRIDE, ::STRIDE]
        cost = 1.0 + CLEARANCE_PENALTY * np.maximum(PREFERRED_CLEARANCE - self._clearance, 0.0)
        self._graph = cell_graph(self._clearance >= ground.radius, cost, STRIDE * CELL)

    def route(self, start: Place, target: Place) -> GuideRoute | None:
        """Return the route between two places, each moved to its nearest free node; None if there is none."""
        goal, first = self._free_node(target), self._free_node(start)
        if goal is None or first is None:
            return None
        left, following = dijkstra(self._graph, directed=False, indices=goal, return_predecessors=True)
        if not np.isfinite(left[first]):
            return None
        nodes = [first]
        while nodes[-1] != goal:
            nodes.append(int(following[nodes[-1]]))
        places = [start, *(self._place(node) for node in nodes), target]
        return GuideRoute(self._straightened(places), left.reshape(self._clearance.shape))

    def remaining_cost(self, route: GuideRoute, x: float, z: float) -> float:
        """Return the remaining cost of a route from a place, in units."""
        column, row = self._ground.cell(x, z)
        columns, rows = route.left.shape
        return float(route.left[min((column + 1) // STRIDE, columns - 1), min((row + 1) // STRIDE, rows - 1)])

    def _free_node(self, place: Place) -> int | None:
        columns, rows = np.nonzero(self._clearance >= self._ground.radius)
        if not len(columns):
            return None
        x, z = self._ground.centre(0, 0)
        away = np.hypot(x + columns * STRIDE * CELL - place[0], z + rows * STRIDE * CELL - place[1])
        nearest = int(away.argmin())
        return int(columns[nearest] * self._clearance.shape[1] + rows[nearest])

    def _place(self, node: int) -> Place:
        column, row = divmod(node, self._clearance.shape[1])
        return self._ground.centre(column * STRIDE, row * STRIDE)

    def _straightened(self, places: Sequence[Place]) -> tuple[Place, ...]:
        """Remove the places that a straight line can skip without coming nearer to a wall."""
        kept, at = [places[0]], 0
        while at < len(places) - 1:
            ahead = at + 1
            for further in range(len(places) - 1, at + 1, -1):
                clearance = min(self._clearance_at(place) for place in places[at : further + 1])
                if self._clearance_along(places[at], places[further]) >= min(clearance, PREFERRED_CLEARANCE) - SLACK:
                    ahead = further
                    break
            kept.append(places[ahead])
            at = ahead
        return tuple(kept)

    def _clearance_at(self, place: Place) -> float:
        return float(self._ground.clearance[self._ground.cell(*place)])

    def _clearance_along(self, start: Place, end: Place) -> float:
        count = max(2, math.ceil(math.dist(start, end) / CELL))
        return min(
            self._clearance_at((start[0] + (end[0] - start[0]) * i / count, start[1] + (end[1] - start[1]) * i / count))
            for i in range(count + 1)
        )
