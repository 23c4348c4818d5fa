"""Exact collision checks on the ground plane: the agent's disc, moved along a straight line, against upright boxes.

The rules need nothing else from physics. Only a box's footprint matters, a rectangle, as every collider is solid at
the height at which agents collide. The arithmetic is plain double precision.
"""

import math
from collections.abc import Container, Iterable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple, Self

from arramon_client.world import AGENT_RADIUS
from arramon_server.sim.scene import Body, Scene

PROBE_HEIGHT = 0.1
"""Height above the ground, in units, at which agents collide. Every collider is solid there: only footprints matter."""

TOUCHING = 0.001
"""Largest difference, in units, between AGENT_RADIUS and a body's distance from the agent's way at which the exact
distance decides in all implementations: there the answer of a physics engine depends on its solver."""

_CELL = 4.0
"""Side of a cell of the index, in units."""

_CACHED = 8192
"""Number of cached footprints of added bodies, about 300 bytes each."""

Place = tuple[float, float]
"""(X, Y) on the scene's ground plane, in units."""


@dataclass(frozen=True, slots=True)
class Footprint:
    """A rectangle on the ground plane: the footprint of a body's collider.

    Attributes:
        x, y: centre, in units.
        sin, cos: sine and cosine of the heading of its own Y axis, clockwise from +Y.
        half_width, half_length: half extents along its own X and Y axes, in units.
    """

    x: float
    y: float
    sin: float
    cos: float
    half_width: float
    half_length: float

    @classmethod
    def of(cls, body: Body) -> Self:
        """Return the footprint of a body.

        Raises:
            ValueError: if the body has no collider, or one that is not solid at PROBE_HEIGHT: collisions would then
                depend on more than its footprint.
        """
        box, (x, y, low) = body.collider, body.position
        if box is None:
            raise ValueError(f"body {body.name!r} has no collider, so it has no footprint")
        if not low <= PROBE_HEIGHT <= low + box.height:
            raise ValueError(
                f"body {body.name!r} is solid from {low:g} to {low + box.height:g} units above the ground, "
                f"expected a body that is solid at {PROBE_HEIGHT:g}, where agents collide"
            )
        angle = math.radians(body.heading)
        return cls(x, y, math.sin(angle), math.cos(angle), box.half_width, box.half_length)

    def distance(self, start: Place, end: Place) -> float:
        """Return the distance of the segment between two places from the rectangle, in units; 0 if they meet.

        They meet unless one of three axes separates them: the rectangle's own two, and the segment's normal. Otherwise
        they are nearest to each other at an end of the segment, or at a corner of the rectangle whose foot on the
        segment's line lies between the ends.
        """
        sin, cos, width, length = self.sin, self.cos, self.half_width, self.half_length
        dx, dy = start[0] - self.x, start[1] - self.y
        u0, v0 = dx * cos - dy * sin, dx * sin + dy * cos
        dx, dy = end[0] - self.x, end[1] - self.y
        u1, v1 = dx * cos - dy * sin, dx * sin + dy * cos
        nearest = min(_squared_distance(u0, v0, width, length), _squared_distance(u1, v1, width, length))
        du, dv = u1 - u0, v1 - v0
        squared = du * du + dv * dv
        left = right = False
        for u, v in ((width, length), (-width, length), (-width, -length), (width, -length)):
            p, q = u - u0, v - v0
            cross = du * q - dv * p
            if cross >= 0.0:
                left = True
            if cross <= 0.0:
                right = True
            if 0.0 < p * du + q * dv < squared:
                nearest = min(nearest, cross * cross / squared)
        overlap = min(u0, u1) <= width and max(u0, u1) >= -width and min(v0, v1) <= length and max(v0, v1) >= -length
        return 0.0 if left and right and overlap else math.sqrt(nearest)


class _Solid(NamedTuple):
    """A solid body with its footprint, and the bounds of the positions where an agent may touch it, in units."""

    body: Body
    footprint: Footprint
    west: float
    east: float
    south: float
    north: float


class Footprints:
    """The solid bodies of a scene on the ground plane, for collision checks (`rules.CollisionCheck`). Thread-safe.

    Args:
        scene: its bodies.

    Raises:
        ValueError: for a collider that is not solid at PROBE_HEIGHT.
    """

    def __init__(self, scene: Scene) -> None:
        solids = [_solid(body) for body in scene.bodies if body.collider is not None]
        cells: dict[tuple[int, int], list[_Solid]] = {}
        for solid in solids:
            for i in _cells(solid.west, solid.east):
                for j in _cells(solid.south, solid.north):
                    cells.setdefault((i, j), []).append(solid)
        self._cells = {cell: tuple(found) for cell, found in cells.items()}
        self._west = min((solid.west for solid in solids), default=0.0)
        self._east = max((solid.east for solid in solids), default=0.0)
        self._south = min((solid.south for solid in solids), default=0.0)
        self._north = max((solid.north for solid in solids), default=0.0)
        self._added = lru_cache(_CACHED)(_solid)

    def way_is_free(self, start: Place, end: Place, removed: Container[Body] = (), added: Iterable[Body] = ()) -> bool:
        """Return whether the agent's disc can move straight from `start` to `end` without touching a solid body.

        Args:
            start: (X, Y) on the scene's ground plane, units.
            end: the same.
            removed: bodies of the scene to ignore.
            added: bodies in addition to those of the scene, each with a collider.

        Raises:
            ValueError: if one of `added` has no collider, or one that is not solid at PROBE_HEIGHT.
        """
        return all(distance > AGENT_RADIUS for distance in self._distances(start, end, removed, added))

    def distance(self, start: Place, end: Place, removed: Container[Body] = (), added: Iterable[Body] = ()) -> float:
        """Return the distance of a way from the nearest body, in units; inf if none is within AGENT_RADIUS + TOUCHING.

        Args and Raises: as `way_is_free`.
        """
        nearest = min(self._distances(start, end, removed, added), default=math.inf)
        return nearest if nearest <= AGENT_RADIUS + TOUCHING else math.inf

    def _distances(self, start: Place, end: Place, removed: Container[Body], added: Iterable[Body]) -> Iterator[float]:
        """Yield the distances of a way from bodies, at least from all that are within AGENT_RADIUS + TOUCHING."""
        (x0, y0), (x1, y1) = start, end
        if x0 > x1:
            x0, x1 = x1, x0
        if y0 > y1:
            y0, y1 = y1, y0
        for i in _cells(max(x0, self._west), min(x1, self._east)):
            for j in _cells(max(y0, self._south), min(y1, self._north)):
                for body, footprint, west, east, south, north in self._cells.get((i, j), ()):
                    if x0 <= east and x1 >= west and y0 <= north and y1 >= south and body not in removed:
                        yield footprint.distance(start, end)
        for _, footprint, west, east, south, north in map(self._added, added):
            if x0 <= east and x1 >= west and y0 <= north and y1 >= south:
                yield footprint.distance(start, end)

    def close(self) -> None:
        """Do nothing: plane geometry holds nothing to free. A physics engine does (`bullet.Obstacles`)."""


def _squared_distance(u: float, v: float, width: float, length: float) -> float:
    """Return the squared distance of a point from a rectangle around the origin, given its half extents."""
    across, along = abs(u) - width, abs(v) - length
    if across <= 0.0:
        return along * along if along > 0.0 else 0.0
    return across * across + along * along if along > 0.0 else across * across


def _solid(body: Body) -> _Solid:
    footprint = Footprint.of(body)
    sin, cos = abs(footprint.sin), abs(footprint.cos)
    reach = AGENT_RADIUS + 2 * TOUCHING
    across = footprint.half_width * cos + footprint.half_length * sin + reach
    along = footprint.half_width * sin + footprint.half_length * cos + reach
    return _Solid(body, footprint, footprint.x - across, footprint.x + across, footprint.y - along, footprint.y + along)


def _cells(low: float, high: float) -> range:
    """Return the numbers of the cells between two coordinates, both included."""
    return range(math.floor(low / _CELL), math.floor(high / _CELL) + 1)
