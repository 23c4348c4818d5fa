"""Free ground of a section: a raster of clearances, and collision tests for straight moves of the agent's disc."""

import math
from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from arramon.v1.evaluation_pb2 import Obstacle

CELL = 0.2
"""Side of a raster cell, in units."""

MAX_CLEARANCE = 1.5
"""Maximum clearance stored in the raster, in units."""

INDEX_SQUARE = 4.0
"""Side of the squares of the spatial index of obstacles, in units."""

MARGIN = 0.01
"""Required distance from obstacles beyond the disc's radius, in units, so that rounding cannot block a planned path."""

Place = tuple[float, float]
"""(x, z), in units."""

Clearance = npt.NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class SolidRectangle:
    """A solid rectangle: centre, half extents along its own axes, sine and cosine of its heading."""

    x: float
    z: float
    half_width: float
    half_length: float
    sin: float
    cos: float

    def to_local(self, x: float, z: float) -> tuple[float, float]:
        """Return a point in the rectangle's frame."""
        dx, dz = x - self.x, z - self.z
        return dx * self.cos - dz * self.sin, dx * self.sin + dz * self.cos

    def is_nearer(self, start: Place, end: Place, distance: float) -> bool:
        """Return whether the segment from start to end comes nearer to it than `distance`."""
        ax, az = self.to_local(*start)
        bx, bz = self.to_local(*end)
        w, h = self.half_width, self.half_length
        if max(ax, bx) < -w - distance or min(ax, bx) > w + distance:
            return False
        if max(az, bz) < -h - distance or min(az, bz) > h + distance:
            return False
        if _crosses(ax, az, bx, bz, w, h):
            return True
        for px, pz in ((ax, az), (bx, bz)):
            if math.hypot(max(abs(px) - w, 0.0), max(abs(pz) - h, 0.0)) < distance:
                return True
        return any(distance_to_segment(cx, cz, ax, az, bx, bz) < distance for cx in (-w, w) for cz in (-h, h))


class ClearanceMap:
    """Raster of clearances of a section, with exact collision tests.

    Args:
        obstacles: all solid rectangles.
        radius: radius of the agent's disc, in units.
        include: points (x, z) that the raster must cover, besides the obstacles.

    Attributes:
        radius: radius of the agent's disc.
        clearance: (columns along x, rows along z) float32, the distance from a cell's centre to the nearest obstacle,
            in units, at most MAX_CLEARANCE.
    """

    def __init__(self, obstacles: Iterable[Obstacle], radius: float, include: Sequence[Place] = ()) -> None:
        self.radius = radius
        self._rectangles = [_rectangle(obstacle) for obstacle in obstacles]
        xs = [r.x for r in self._rectangles] + [x for x, _ in include]
        zs = [r.z for r in self._rectangles] + [z for _, z in include]
        border = MAX_CLEARANCE + 2.0
        self._left, self._bottom = min(xs, default=0.0) - border, min(zs, default=0.0) - border
        columns = math.ceil((max(xs, default=0.0) + border - self._left) / CELL)
        rows = math.ceil((max(zs, default=0.0) + border - self._bottom) / CELL)
        self.clearance = self._rasterise(columns, rows)
        self._near: defaultdict[tuple[int, int], list[SolidRectangle]] = defaultdict(list)
        for rectangle in self._rectangles:
            self._enter(rectangle)

    def cell(self, x: float, z: float) -> tuple[int, int]:
        """Return the raster cell of a place, or the nearest one if the place is outside."""
        columns, rows = self.clearance.shape
        column, row = int((x - self._left) / CELL), int((z - self._bottom) / CELL)
        return min(max(column, 0), columns - 1), min(max(row, 0), rows - 1)

    def centre(self, column: int, row: int) -> tuple[float, float]:
        """Return (x, z) of a cell's centre."""
        return self._left + (column + 0.5) * CELL, self._bottom + (row + 0.5) * CELL

    def covers(self, x: float, z: float) -> bool:
        """Return whether a place is on the raster."""
        columns, rows = self.clearance.shape
        return bool(0 <= x - self._left < columns * CELL and 0 <= z - self._bottom < rows * CELL)

    def is_free(self, start: Place, end: Place) -> bool:
        """Return whether the agent's disc can move straight from start to end; places off the raster are not free."""
        pieces = max(1, math.ceil(math.dist(start, end)))
        return all(
            self._is_piece_free(_between(start, end, i / pieces), _between(start, end, (i + 1) / pieces))
            for i in range(pieces)
        )

    def _is_piece_free(self, start: Place, end: Place) -> bool:
        """Return the result of `is_free` for a segment of at most one unit."""
        distance = self.radius + MARGIN
        middle = _between(start, end, 0.5)
        if not self.covers(*middle):
            return False
        # The clearance on the segment differs from that of the middle's cell by at most half its length and half a
        # cell's diagonal.
        slack = math.dist(start, end) / 2 + CELL * math.sqrt(0.5)
        clearance = float(self.clearance[self.cell(*middle)])
        if clearance - slack >= distance:
            return True
        bucket = math.floor(middle[0] / INDEX_SQUARE), math.floor(middle[1] / INDEX_SQUARE)
        return not any(rectangle.is_nearer(start, end, distance) for rectangle in self._near.get(bucket, ()))

    def _rasterise(self, columns: int, rows: int) -> Clearance:
        clearance = np.full((columns, rows), MAX_CLEARANCE, np.float32)
        for rectangle in self._rectangles:
            reach = math.hypot(rectangle.half_width, rectangle.half_length) + MAX_CLEARANCE
            first = int((rectangle.x - reach - self._left) / CELL), int((rectangle.z - reach - self._bottom) / CELL)
            last = int((rectangle.x + reach - self._left) / CELL), int((rectangle.z + reach - self._bottom) / CELL)
            window = (
                slice(max(first[0], 0), min(last[0] + 1, columns)),
                slice(max(first[1], 0), min(last[1] + 1, rows)),
            )
            dx = self._left + (np.arange(window[0].start, window[0].stop)[:, None] + 0.5) * CELL - rectangle.x
            dz = self._bottom + (np.arange(window[1].start, window[1].stop)[None, :] + 0.5) * CELL - rectangle.z
            across = np.abs(dx * rectangle.cos - dz * rectangle.sin) - rectangle.half_width
            along = np.abs(dx * rectangle.sin + dz * rectangle.cos) - rectangle.half_length
            distance = np.hypot(np.maximum(across, 0.0), np.maximum(along, 0.0))
            np.minimum(clearance[window], distance, out=clearance[window], casting="same_kind")
        return clearance

    def _enter(self, rectangle: SolidRectangle) -> None:
        reach = math.hypot(rectangle.half_width, rectangle.half_length) + MAX_CLEARANCE
        for column in range(
            math.floor((rectangle.x - reach) / INDEX_SQUARE), math.floor((rectangle.x + reach) / INDEX_SQUARE) + 1
        ):
            for row in range(
                math.floor((rectangle.z - reach) / INDEX_SQUARE), math.floor((rectangle.z + reach) / INDEX_SQUARE) + 1
            ):
                self._near[column, row].append(rectangle)


def _rectangle(obstacle: Obstacle) -> SolidRectangle:
    angle = math.radians(obstacle.heading)
    return SolidRectangle(
        obstacle.x, obstacle.z, obstacle.half_width, obstacle.half_length, math.sin(angle), math.cos(angle)
    )


def _between(start: Place, end: Place, share: float) -> tuple[float, float]:
    return start[0] + (end[0] - start[0]) * share, start[1] + (end[1] - start[1]) * share


def _crosses(ax: float, az: float, bx: float, bz: float, w: float, h: float) -> bool:
    """Return whether the segment from a to b touches the rectangle of half extents w and h at the origin (slabs)."""
    low, high = 0.0, 1.0
    for start, delta, half in ((ax, bx - ax, w), (az, bz - az, h)):
        if abs(delta) < 1e-12:
            if abs(start) > half:
                return False
            continue
        first, second = sorted(((-half - start) / delta, (half - start) / delta))
        low, high = max(low, first), min(high, second)
    return low <= high


def distance_to_segment(px: float, pz: float, ax: float, az: float, bx: float, bz: float) -> float:
    """Return the distance of the point p from the segment from a to b, in units."""
    dx, dz = bx - ax, bz - az
    square = dx * dx + dz * dz
    share = 0.0 if square == 0.0 else min(max(((px - ax) * dx + (pz - az) * dz) / square, 0.0), 1.0)
    return math.hypot(px - ax - share * dx, pz - az - share * dz)
