"""A raster over a section's ground, along its streets, for planning buildings and furniture."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Points = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

CELL = 0.25
"""Side length of a cell, in units."""


@dataclass(frozen=True, slots=True)
class Grid:
    """Cells of CELL units; the first axis of every mask is `across`, the second `along`.

    Coordinates in the turned street frame are (across, along): `along` points in the direction of `heading`, `across`
    90 degrees clockwise from it. Both frames have the same origin.

    Attributes:
        heading: of the `along` axis, degrees clockwise from +z.
        origin: (across, along) of the first cell's outer corner, in units.
        shape: number of cells along each axis.
    """

    heading: float
    origin: tuple[float, float]
    shape: tuple[int, int]

    @classmethod
    def around(cls, points: Points, heading: float, margin: float) -> "Grid":
        """Return the grid that contains all `points` (n, 2) of (x, z) with a margin of `margin` units on each side."""
        turned = to_street_frame(points, heading)
        low = np.floor((turned.min(axis=0) - margin) / CELL) * CELL
        shape = np.ceil((turned.max(axis=0) + margin - low) / CELL).astype(int)
        return cls(heading, (float(low[0]), float(low[1])), (int(shape[0]), int(shape[1])))

    def centres(self) -> Points:
        """Return the (x, z) of every cell's centre, (cells, 2), in the order of a mask's `ravel`."""
        across = self.origin[0] + CELL * (np.arange(self.shape[0]) + 0.5)
        along = self.origin[1] + CELL * (np.arange(self.shape[1]) + 0.5)
        turned = np.stack(np.meshgrid(across, along, indexing="ij"), axis=-1).reshape(-1, 2)
        return to_world_frame(turned, self.heading)

    def world(self, across: float, along: float) -> tuple[float, float]:
        """Return the (x, z) of a place given in cells from the grid's origin, fractions included."""
        turned = np.array([[self.origin[0] + CELL * across, self.origin[1] + CELL * along]])
        x, z = to_world_frame(turned, self.heading)[0]
        return float(x), float(z)


def to_street_frame(points: Points, heading: float) -> Points:
    """Convert (n, 2) of (x, z) in the world frame to (n, 2) of (across, along) in the street frame.

    Rounded to a billionth of a unit and computed elementwise: unlike a matrix product, identical on every machine.
    """
    sin, cos = math.sin(math.radians(heading)), math.cos(math.radians(heading))
    x, z = points[:, 0], points[:, 1]
    turned: Points = np.stack([x * cos - z * sin, x * sin + z * cos], axis=1)
    return turned.round(9)


def to_world_frame(turned: Points, heading: float) -> Points:
    """Convert (n, 2) of (across, along) in the street frame to (n, 2) of (x, z) in the world frame."""
    return to_street_frame(turned, -heading)


def sample_points(paths: Sequence[Points], spacing: float = 0.1) -> Points:
    """Return distinct points along all segments of `paths`, at most `spacing` units apart, (m, 2).

    The distance to these points exceeds the distance d to the segments by at most `spacing`^2 / 8d.
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
