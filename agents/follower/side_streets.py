"""Detection of side streets on the agent's own map."""

import math

import numpy as np

from arramon_agents.mapping.ground_map import CELL, SIDE, GroundMap
from arramon_agents.mapping.walk_costs import clearance_of, step_costs
from arramon_lang.street_words import OPENING_DEPTH, OPENING_INSET, OPENING_RANGE, SAME_OPENING

OFFSETS = np.arange(-3.0, 14.0, 0.5)
"""Places along the walk to examine, in units from the agent."""

MIN_DEPTH = 1.0
"""Minimum depth of a side street beyond the walls before it, in units."""

ALONG, INTO = np.arange(-1.0, 3.1, 0.25), np.arange(2.0, 6.1, 0.5)
"""Places along the walk that may be the middle of a side street, from its beginning, and distances into the side street
at which the room there is examined, in units."""

BLOCKED_COST, AWAY_COST = 5.0, 0.05
"""Cost of a blocked place, where a free one costs at least 1, and of a unit away from the side street's beginning."""

ROOM = 48
"""Cells to each side of the beginning of a side street that are examined."""

MIN_PLACES = 3
"""Minimum number of consecutive places of a side street."""


def find_next_side_street(ground: GroundMap, x: float, z: float, angle: float, side: int) -> tuple[float, float] | None:
    """Return the place at which to turn into the nearest side street ahead; None if none is known yet.

    Args:
        ground: the agent's map.
        x, z, angle: position and direction of the walk, `angle` in radians.
        side: 1 for the right, -1 for the left.

    Returns:
        (x, z) on the line of the walk.
    """
    runs, walls = ground.measure_free_widths(x, z, angle, side, OFFSETS, OPENING_RANGE)
    for start in find_side_streets(runs.tolist(), walls.tolist()):
        along = float(OFFSETS[start]) + OPENING_INSET
        if along > 0.0:
            return x + along * math.sin(angle), z + along * math.cos(angle)
    return None


def find_middle(ground: GroundMap, place: tuple[float, float], angle: float, side: int) -> tuple[float, float]:
    """Return the place at which to turn into the middle of a side street.

    Args:
        ground: the agent's map.
        place: (x, z) near the beginning of the side street, on the line of the walk.
        angle: direction of the walk, in radians.
        side: 1 for the right, -1 for the left.

    Returns:
        (x, z) on the line of the walk, from which the way into the side street has the most room.
    """
    sin, cos = math.sin(angle), math.cos(angle)
    half = SIDE // 2
    row, column = (min(max(int(each / CELL) + half, ROOM), SIDE - ROOM) for each in place)
    solid = ground.layers()[0][row - ROOM : row + ROOM, column - ROOM : column + ROOM]
    costs = np.where(
        ground.blocked_layer()[row - ROOM : row + ROOM, column - ROOM : column + ROOM],
        BLOCKED_COST,
        step_costs(clearance_of(solid)),
    )
    xs = place[0] + ALONG[:, None] * sin + side * INTO * cos
    zs = place[1] + ALONG[:, None] * cos - side * INTO * sin
    rows, columns = (np.floor(each / CELL).astype(int) + half for each in (xs, zs))
    total = costs[rows - row + ROOM, columns - column + ROOM].sum(axis=1) + AWAY_COST * np.abs(ALONG)
    along = float(ALONG[total.argmin()])
    return place[0] + along * sin, place[1] + along * cos


class SideStreets:
    """Side streets found along one walk, in order.

    Args:
        x, z, angle: start of the walk, and its direction in radians.
    """

    def __init__(self, x: float, z: float, angle: float) -> None:
        self._x, self._z, self._sin, self._cos = x, z, math.sin(angle), math.cos(angle)
        self._found: list[tuple[float, int, tuple[float, float]]] = []

    def add(self, ground: GroundMap, x: float, z: float, angle: float) -> None:
        """Add the side streets that are visible on the map from a place on the walk."""
        for side in (-1, 1):
            runs, walls = ground.measure_free_widths(x, z, angle, side, OFFSETS, OPENING_RANGE)
            for start in find_side_streets(runs.tolist(), walls.tolist()):
                along = float(OFFSETS[start]) + OPENING_INSET
                place = x + along * math.sin(angle), z + along * math.cos(angle)
                far = (place[0] - self._x) * self._sin + (place[1] - self._z) * self._cos
                near = [each for each in self._found if each[1] == side and abs(each[0] - far) < SAME_OPENING / 2]
                if far > 1.0 and not near:
                    self._found.append((far, side, place))

    def find(self, side: int, number: int) -> tuple[float, float] | None:
        """Return the place of a side street by number (from 0) on a side, or on any side for 0; None if unknown."""
        kept: list[tuple[float, tuple[float, float]]] = []
        for far, own, place in sorted(self._found):
            if side in (0, own) and (not kept or far - kept[-1][0] >= SAME_OPENING or side != 0):
                kept.append((far, place))
        return kept[number][1] if number < len(kept) else None

    def nearest(self, side: int, x: float, z: float) -> tuple[float, float] | None:
        """Return the place of the side street on a side that is nearest to (x, z); None if there is none."""
        places = [place for _, own, place in self._found if own == side]
        return min(places, key=lambda place: math.hypot(place[0] - x, place[1] - z), default=None)


def find_side_streets(runs: list[float], walls: list[bool]) -> list[int]:
    """Find side streets in depths measured along a walk; return the index of the first place of each.

    A side street begins right after a wall, and continues with clearly deeper places. At first only a part of it is
    visible behind the corner: it begins right after the wall even if its first places have not been seen, and its known
    depth counts.

    Args:
        runs: distance to the side up to which the ground is free, by place, in units.
        walls: whether that distance ends at a wall, by place.
    """
    found: list[int] = []
    beside, last, open_places = 0.0, None, 0
    for i, (run, wall) in enumerate(zip(runs, walls, strict=True)):
        if wall and run < OPENING_RANGE - OPENING_DEPTH and (last is None or run < beside + OPENING_DEPTH):
            beside, last, open_places = run, i, 0
        elif last is not None and run >= beside + MIN_DEPTH:
            open_places += 1
            if open_places == MIN_PLACES:
                found.append(last + 1)
                last = None
    return found
