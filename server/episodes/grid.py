"""A raster over a section's ground, turned so that its axes run along the section's streets."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Points = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

CELL = 0.25
"""Side of a cell, in units."""


@dataclass(frozen=True, slots=True)
class Grid:
    """Cells of CELL units; the first axis of every mask runs along `across`, the second along `along`.

    Coordinates in the turned frame are (across, along): `along` runs in the direction of `heading`, `across` at 90
    degrees clockwise from it. Both frames have the same origin.

    Attributes:
        heading: of the `along` axis, degrees clockwise from +z.
        origin: (across, along) of the first cell's outer corner, in units.
        shape: cells along each axis.
    """

    heading: float
    origin: tuple[float, float]
    shape: tuple[int, int]

    @classmethod
    def around(cls, points: Points, heading: float, margin: float) -> "Grid":
        """The grid that holds all `points` (n, 2) of (x, z) with `margin` units to spare on each side."""
        turned = turn(points, heading)
        low = np.floor((turned.min(axis=0) - margin) / CELL) * CELL
        shape = np.ceil((turned.max(axis=0) + margin - low) / CELL).astype(int)
        return cls(heading, (float(low[0]), float(low[1])), (int(shape[0]), int(shape[1])))

    def centres(self) -> Points:
        """(cells, 2): the (x, z) of every cell's centre, in the order of a mask's `ravel`."""
        across = self.origin[0] + CELL * (np.arange(self.shape[0]) + 0.5)
        along = self.origin[1] + CELL * (np.arange(self.shape[1]) + 0.5)
        turned = np.stack(np.meshgrid(across, along, indexing="ij"), axis=-1).reshape(-1, 2)
        return turn_back(turned, self.heading)

    def world(self, across: float, along: float) -> tuple[float, float]:
        """The (x, z) of a place given in cells from the grid's origin, fractions included."""
        turned = np.array([[self.origin[0] + CELL * across, self.origin[1] + CELL * along]])
        x, z = turn_back(turned, self.heading)[0]
        return float(x), float(z)


def turn(points: Points, heading: float) -> Points:
    """(n, 2) of (x, z) in the world as (n, 2) of (across, along).

    To a billionth of a unit, and by single operations: the same on every machine, which a product of matrices is not.
    """
    sin, cos = math.sin(math.radians(heading)), math.cos(math.radians(heading))
    x, z = points[:, 0], points[:, 1]
    turned: Points = np.stack([x * cos - z * sin, x * sin + z * cos], axis=1)
    return turned.round(9)


def turn_back(turned: Points, heading: float) -> Points:
    """(n, 2) of (across, along) as (n, 2) of (x, z) in the world."""
    return turn(turned, -heading)


def sample(paths: Sequence[Points], spacing: float = 0.1) -> Points:
    """(m, 2): points along all segments of `paths`, at most `spacing` units apart, without those that repeat.

    A distance to these is at most `spacing`^2 / 8d more than the distance d to the segments themselves.
    """
    pieces = [np.zeros((0, 2))]
    for path in paths:
        pieces.append(path)
        if len(path) > 1:
            longest = float(np.linalg.norm(np.diff(path, axis=0), axis=1).max())
            steps = max(1, int(np.ceil(longest / spacing)))
            fractions = (np.arange(1, steps) / steps)[:, None, None]
            pieces.append((path[:-1] + fractions * np.diff(path, axis=0)).reshape(-1, 2))
    points: Points = np.unique(np.round(np.concatenate(pieces), 3), axis=0)
    return points
