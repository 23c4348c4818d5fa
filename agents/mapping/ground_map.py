"""Occupancy map of the ground in the agent's own frame, with cells of a quarter unit."""

import math

import numpy as np
import numpy.typing as npt

from arramon_agents.perception.scan import Scan

CELL = 0.25
SIDE = 640
"""Cells along each axis: 80 units to each side of the agent's start."""

_OFFSETS = np.array([i * SIDE + j for i in (-1, 0, 1) for j in (-1, 0, 1)])
"""Offsets of the cells around a solid cell that the agent's disc of 0.25 units cannot occupy."""


class GroundMap:
    """Occupancy map: free ground, walls, and cells that the agent's disc cannot occupy.

    Attributes:
        blocked: one byte per cell, 1 where the agent cannot be.
        free: one byte per cell, 1 where the ground was seen to be free.
        wall: one byte per cell, 1 where there is a building.
    """

    def __init__(self) -> None:
        self.blocked = bytearray(SIDE * SIDE)
        self.free = bytearray(SIDE * SIDE)
        self.wall = bytearray(SIDE * SIDE)
        self._blocked = np.frombuffer(self.blocked, np.uint8)
        self._free = np.frombuffer(self.free, np.uint8)
        self._wall = np.frombuffer(self.wall, np.uint8)
        self._solid = np.zeros(SIDE * SIDE, np.uint8)

    def layers(self) -> tuple[npt.NDArray[np.bool_], npt.NDArray[np.bool_], npt.NDArray[np.bool_]]:
        """Return where something solid, free ground and a building was seen, each (SIDE along x, SIDE along z).

        They are views of the map, not copies.
        """
        solid, free, wall = (each.view(np.bool_).reshape(SIDE, SIDE) for each in (self._solid, self._free, self._wall))
        return solid, free, wall

    def blocked_layer(self) -> npt.NDArray[np.bool_]:
        """Return where the agent cannot be, as `layers` does."""
        return self._blocked.view(np.bool_).reshape(SIDE, SIDE)

    def add(self, scan: Scan) -> None:
        """Add a frame's free ground and obstacles."""
        self._free[_indices(scan.free[:, 0], scan.free[:, 1])] = 1
        if len(scan.obstacles):
            self._enter(_indices(scan.obstacles[:, 0], scan.obstacles[:, 1]), scan.walls)

    def block(self, x: float, z: float) -> None:
        """Add an obstacle that blocked a step without having been seen."""
        self._enter(_indices(np.array([x]), np.array([z])), np.array([False]))

    def _enter(self, cells: npt.NDArray[np.int64], walls: npt.NDArray[np.bool_]) -> None:
        self._wall[cells[walls]] = 1
        new = cells[self._solid[cells] == 0]
        if len(new):
            new = np.unique(new)
            self._solid[new] = 1
            around = new[:, None] + _OFFSETS
            self._blocked[np.clip(around, 0, SIDE * SIDE - 1)] = 1

    def free_distance(self, x: float, z: float, angle: float, farthest: float) -> float:
        """Return the distance from (x, z) to the first known obstacle straight ahead, in units; `angle` in radians."""
        sin, cos = math.sin(angle) * CELL, math.cos(angle) * CELL
        blocked = self.blocked
        for i in range(2, int(farthest / CELL) + 1):
            if blocked[cell_index(x + i * sin, z + i * cos)]:
                return (i - 1) * CELL
        return farthest

    def has_line_of_sight(self, x: float, z: float, to_x: float, to_z: float) -> bool:
        """Return whether the straight line between two places crosses no known obstacle."""
        distance = math.hypot(to_x - x, to_z - z)
        return self.free_distance(x, z, math.atan2(to_x - x, to_z - z), distance) >= distance - 2 * CELL

    def nearest_free(self, x: float, z: float) -> tuple[float, float]:
        """Return the place, or the nearest place around it that is not known to be blocked."""
        if not self.blocked[cell_index(x, z)]:
            return x, z
        for radius in (0.5, 1.0, 1.5, 2.0, 2.5):
            for turned in range(8):
                angle = turned * math.pi / 4
                place = x + radius * math.sin(angle), z + radius * math.cos(angle)
                if not self.blocked[cell_index(*place)]:
                    return place
        return x, z

    def measure_free_widths(
        self, x: float, z: float, angle: float, side: int, offsets: npt.NDArray[np.float64], farthest: float
    ) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.bool_]]:
        """Return how far the ground to one side of a line is free, at several places of the line.

        Args:
            x, z, angle: a point on the line, and its direction in radians.
            side: 1 for the right side, -1 for the left.
            offsets: (n,) places on the line, in units from (x, z).
            farthest: maximum distance from the line, in units.

        Returns:
            (n,) distances up to which the ground is known to be without walls, and (n,) whether each ends at a wall.
        """
        sin, cos = math.sin(angle), math.cos(angle)
        out = np.arange(0.0, farthest, CELL)
        xs = x + offsets[:, None] * sin + side * out[None, :] * cos
        zs = z + offsets[:, None] * cos - side * out[None, :] * sin
        cells = _indices(xs, zs)
        wall = self._wall[cells] == 1
        # Walls are hollow and free ground is seen with gaps: known ground ends at two consecutive unknown cells.
        unknown = (self._free[cells] == 0) & ~wall
        unknown[:, :-1] &= unknown[:, 1:]
        ends = wall | unknown
        ends[:, -1] = True
        last = ends.argmax(axis=1)
        return last * CELL, wall[np.arange(len(offsets)), last]

    def frontier(self) -> npt.NDArray[np.float64]:
        """Return (n, 2) of (x, z): free places next to unknown ground."""
        free = self._free.reshape(SIDE, SIDE)
        known = free | self._solid.reshape(SIDE, SIDE)
        edge = np.zeros((SIDE, SIDE), dtype=bool)
        edge[1:-1, 1:-1] = (free[1:-1, 1:-1] == 1) & (
            (known[:-2, 1:-1] & known[2:, 1:-1] & known[1:-1, :-2] & known[1:-1, 2:]) == 0
        )
        edge &= self._blocked.reshape(SIDE, SIDE) == 0
        rows, columns = np.nonzero(edge)
        cells = np.stack([rows, columns], axis=1).astype(np.float64)
        return (cells - SIDE / 2 + 0.5) * CELL


def cell_index(x: float, z: float) -> int:
    """Return the index of the map cell that contains a place."""
    row, column = int(x / CELL + SIDE / 2), int(z / CELL + SIDE / 2)
    return min(max(row, 0), SIDE - 1) * SIDE + min(max(column, 0), SIDE - 1)


def _indices(xs: npt.NDArray[np.floating], zs: npt.NDArray[np.floating]) -> npt.NDArray[np.int64]:
    rows = (xs * np.float32(1.0 / CELL) + np.float32(SIDE / 2)).astype(np.int64)
    columns = (zs * np.float32(1.0 / CELL) + np.float32(SIDE / 2)).astype(np.int64)
    cells: npt.NDArray[np.int64] = _inside(rows) * SIDE + _inside(columns)
    return cells


def _inside(numbers: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    np.maximum(numbers, 0, out=numbers)
    return np.minimum(numbers, SIDE - 1, out=numbers)
