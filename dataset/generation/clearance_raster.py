"""The clearance raster of a section: distances to the nearest solid in each cell, for path planning.

Clearances are integers, so that every machine finds the same paths.
"""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from arramon_dataset.layout.solids import Points, Solids, distance_from_rectangle
from arramon_server.sim.section import Section

CELL = 0.125
"""Side length of a raster cell, in units."""

STRIDE = 3
"""Cells between two neighbouring nodes of the cost fields (see `path_planner.CostField`)."""

FAR = 2500
"""Upper limit of stored clearances, in thousandths of a unit."""

BORDER = 1.0
"""Margin of the raster around a section's bounds, in units; everything outside the bounds counts as solid."""

Numbers = npt.NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class ClearanceRaster:
    """Clearance and street direction at each cell of a section's raster.

    Attributes:
        left, bottom: x and z of the first cell's outer corner, in units.
        clearance: (columns along x, rows along z), thousandths of a unit from a cell's centre to the nearest solid,
            rounded down, at most FAR; 0 outside the section's bounds.
        axes: the same shape, direction of the street in whole degrees in [0, 90): that of the nearest building's walls,
            or the section's heading where no building is near.
        solids: the obstacles to which the clearance is measured.
    """

    left: float
    bottom: float
    clearance: Numbers
    axes: Numbers
    solids: Solids

    @classmethod
    def of(cls, section: Section) -> "ClearanceRaster":
        """Return the clearance raster of a section."""
        x0, z0, x1, z1 = section.bounds
        left, bottom = math.floor(x0 - BORDER), math.floor(z0 - BORDER)
        columns = math.ceil((x1 + BORDER - left) / CELL)
        rows = math.ceil((z1 + BORDER - bottom) / CELL)
        solids = Solids.of(section)
        clearance, _ = rasterise(solids, left, bottom, columns, rows)
        nearest, axes = rasterise(Solids.from_bodies(section.buildings), left, bottom, columns, rows)
        axes = np.where(nearest < FAR, axes, round(section.heading) % 90).astype(np.int32)
        xs, zs = left + CELL * (np.arange(columns) + 0.5), bottom + CELL * (np.arange(rows) + 0.5)
        inside = ((xs >= x0) & (xs <= x1))[:, None] & ((zs >= z0) & (zs <= z1))[None, :]
        return cls(float(left), float(bottom), np.where(inside, clearance, 0).astype(np.int32), axes, solids)

    @property
    def nodes(self) -> tuple[int, int]:
        """Number of nodes of the cost fields along x and along z."""
        columns, rows = self.clearance.shape
        return (columns + STRIDE - 1) // STRIDE, (rows + STRIDE - 1) // STRIDE

    def cell(self, x: float, z: float) -> tuple[int, int]:
        """Return the raster cell of a place, or the nearest cell if the place is outside."""
        columns, rows = self.clearance.shape
        column, row = math.floor((x - self.left) / CELL), math.floor((z - self.bottom) / CELL)
        return min(max(column, 0), columns - 1), min(max(row, 0), rows - 1)

    def node(self, x: float, z: float) -> tuple[int, int]:
        """Return the node nearest to a place."""
        columns, rows = self.nodes
        column, row = self.cell(x, z)
        return min((column + STRIDE // 2) // STRIDE, columns - 1), min((row + STRIDE // 2) // STRIDE, rows - 1)

    def is_in_sight(self, x: float, z: float, to_x: float, to_z: float) -> bool:
        """Return whether the line between two places is free of solids."""
        samples = math.ceil(math.hypot(to_x - x, to_z - z) / CELL)
        shares = ((i + 1) / samples for i in range(samples))
        return all(self.clear_at(x + share * (to_x - x), z + share * (to_z - z)) > 0.0 for share in shares)

    def clear_at(self, x: float, z: float) -> float:
        """Return the clearance of a place's cell, in units."""
        return float(self.clearance[self.cell(x, z)]) / 1000.0


def rasterise(solids: Solids, left: float, bottom: float, columns: int, rows: int) -> tuple[Numbers, Numbers]:
    """Return the clearance and the direction of the nearest solid for each cell, two arrays of (columns, rows).

    The clearance is the distance from the cell's centre to the nearest solid in thousandths of a unit, rounded down, at
    most FAR. The direction is that solid's heading in whole degrees, in [0, 90); of equally near solids, that of the
    first.
    """
    clearance = np.full((columns, rows), FAR, np.int32)
    axes = np.zeros((columns, rows), np.int32)
    for centre, half, heading in zip(solids.centres, solids.halves, solids.headings, strict=True):
        reach = math.hypot(*half) + FAR / 1000.0
        across = _window(centre[0] - left, reach, columns)
        along = _window(centre[1] - bottom, reach, rows)
        xs = left + CELL * (np.arange(across.start, across.stop) + 0.5)
        zs = bottom + CELL * (np.arange(along.start, along.stop) + 0.5)
        places: Points = np.stack(np.meshgrid(xs, zs, indexing="ij"), axis=-1)
        # Rounded before the floor, so that floating-point differences between machines do not change the result.
        distance = np.floor(np.round(distance_from_rectangle(places, centre, half, float(heading)) * 1000.0, 3))
        window = (across, along)
        nearer = distance < clearance[window]
        clearance[window] = np.where(nearer, distance, clearance[window])
        axes[window] = np.where(nearer, round(float(heading)) % 90, axes[window])
    return clearance, axes


def _window(middle: float, reach: float, count: int) -> slice:
    first, last = math.floor((middle - reach) / CELL), math.ceil((middle + reach) / CELL)
    return slice(min(max(first, 0), count), min(max(last, 0), count))
