"""The sample's two hand-drawn street plans, and path finding with the agent's actions.

Places are in a town's own frame, in units: `along` the streets' main heading, and `across` it to the right.
"""

import heapq
import math
from collections import deque
from dataclasses import dataclass, field
from functools import cached_property
from itertools import count
from typing import NamedTuple

CELL = 2.0
"""Side of a plan's character, in units."""

HEADING = 28.8
"""Direction of both towns' streets, degrees clockwise from +z."""

FIRST_PLAN = """
####################
######..############
######..############
##LL..++..+....LL###
##LL..++..+....LL###
##..######a####..###
##..######a####..###
##..######a####..###
##..######a####..###
##LL.++...+....++.##
##LL.++...+....++.##
#####..########..###
#####..########..###
#####..########..###
#####++........LL###
#####++........LL###
#####..#############
#####..#############
####################
"""

SECOND_PLAN = """
####################
########..##########
########..##########
##LL....++.....LL###
##LL....++.....LL###
##..###########..###
##..####....###..###
##..####....###..###
##++....++.....++..#
##++....++.....++..#
###a####..##########
###a####..##########
###a####..##########
##LL....++....######
##LL....++....######
########..##########
########..##########
####################
"""

_HALF_ROOT = math.sqrt(3.0) / 2
_SIN = ((0, 0), (1, 0), (0, 1), (2, 0), (0, 1), (1, 0), (0, 0), (-1, 0), (0, -1), (-2, 0), (0, -1), (-1, 0))
"""The sine of 30k degrees as (halves, half square roots of 3): places reached are sums of these, and so exact."""


class TownPoint(NamedTuple):
    """A place in a town."""

    across: float
    along: float


class Spot(NamedTuple):
    """An agent's pose: counts of (1/2, sqrt(3)/2) on each axis, and its heading in steps of 30 degrees."""

    across: tuple[int, int]
    along: tuple[int, int]
    heading: int

    @property
    def place(self) -> TownPoint:
        """The position in units."""
        return TownPoint(
            self.across[0] / 2 + self.across[1] * _HALF_ROOT,
            self.along[0] / 2 + self.along[1] * _HALF_ROOT,
        )

    def turned(self, steps: int) -> "Spot":
        """Return the pose turned clockwise by `steps` times 30 degrees."""
        return self._replace(heading=(self.heading + steps) % 12)

    def ahead(self) -> "Spot":
        """Return the pose one unit ahead."""
        sin, cos = _SIN[self.heading], _SIN[(self.heading + 3) % 12]
        across = (self.across[0] + sin[0], self.across[1] + sin[1])
        along = (self.along[0] + cos[0], self.along[1] + cos[1])
        return Spot(across, along, self.heading)

    def local(self, place: TownPoint) -> TownPoint:
        """Return `place` relative to this pose: (units to the right, units ahead)."""
        here = self.place
        dx, dz = place.across - here.across, place.along - here.along
        (s, t), (c, d) = _SIN[self.heading], _SIN[(self.heading + 3) % 12]
        sin, cos = s / 2 + t * _HALF_ROOT, c / 2 + d * _HALF_ROOT
        return TownPoint(dx * cos - dz * sin, dx * sin + dz * cos)


@dataclass(frozen=True)
class Town:
    """A street plan.

    Attributes:
        plan: rows of characters, the farthest first: `#` built up, `.` street, `+` intersection, `L` corner, `a` alley.
        origin: (x, z) of the plan's near left corner in the world frame.
        first_map_id: `mapId` of its first episode.
    """

    plan: str
    origin: tuple[float, float]
    first_map_id: int
    _clearances: dict[TownPoint, float] = field(default_factory=dict, compare=False, repr=False)

    @cached_property
    def rows(self) -> tuple[str, ...]:
        """The plan's rows, the nearest first."""
        return tuple(reversed(self.plan.split()))

    def at(self, place: TownPoint) -> str:
        """Return the plan's character at a place."""
        row, column = math.floor(place.along / CELL), math.floor(place.across / CELL)
        return self.rows[row][column] if 0 <= row < len(self.rows) and 0 <= column < len(self.rows[row]) else "#"

    def clearance(self, place: TownPoint) -> float:
        """Return the distance to the nearest building, in units, at most CELL."""
        if place not in self._clearances:
            row, column = math.floor(place.along / CELL), math.floor(place.across / CELL)
            nearest = CELL
            for near_row in (row - 1, row, row + 1):
                for near_column in (column - 1, column, column + 1):
                    if self.at(TownPoint((near_column + 0.5) * CELL, (near_row + 0.5) * CELL)) == "#":
                        dx = max(near_column * CELL - place.across, place.across - (near_column + 1) * CELL, 0.0)
                        dz = max(near_row * CELL - place.along, place.along - (near_row + 1) * CELL, 0.0)
                        nearest = min(nearest, math.sqrt(dx * dx + dz * dz))
            self._clearances[place] = nearest
        return self._clearances[place]

    def world(self, place: TownPoint) -> tuple[float, float]:
        """Return a place's (x, z) in the world frame."""
        sin, cos = math.sin(math.radians(HEADING)), math.cos(math.radians(HEADING))
        x, z = place.across * cos + place.along * sin, place.along * cos - place.across * sin
        return round(self.origin[0] + x, 5), round(self.origin[1] + z, 5)

    @cached_property
    def spots(self) -> tuple[TownPoint, ...]:
        """Places for objects and starts: whole units, at least one unit from every wall."""
        height, width = len(self.rows) * int(CELL), len(self.rows[0]) * int(CELL)
        places = (TownPoint(float(across), float(along)) for across in range(width) for along in range(height))
        return tuple(place for place in places if self.clearance(place) >= 1.0)

    @cached_property
    def zones(self) -> dict[tuple[int, int], tuple[str, int]]:
        """For each cell (row, column) of an intersection or a corner, its character and number."""
        found: dict[tuple[int, int], tuple[str, int]] = {}
        for row, text in enumerate(self.rows):
            for column, mark in enumerate(text):
                if mark in "+L" and (row, column) not in found:
                    number, waiting = len(found), [(row, column)]
                    while waiting:
                        r, c = waiting.pop()
                        if self.rows[r][c] == mark and (r, c) not in found:
                            found[r, c] = (mark, number)
                            waiting += [(r + 1, c), (r - 1, c), (r, c + 1), (r, c - 1)]
        return found

    def distances(self, goal: TownPoint) -> dict[tuple[int, int], int]:
        """Return approximate distances from `goal` to the points of a one-unit raster, in right-angled moves."""
        start = (round(goal.across), round(goal.along))
        found, waiting = {start: 0}, deque([start])
        while waiting:
            across, along = waiting.popleft()
            for near in ((across + 1, along), (across - 1, along), (across, along + 1), (across, along - 1)):
                if near not in found and self.clearance(TownPoint(float(near[0]), float(near[1]))) >= 0.9:
                    found[near] = found[across, along] + 1
                    waiting.append(near)
        return found


TOWNS = (Town(FIRST_PLAN, (-30.0, 5.0), 101), Town(SECOND_PLAN, (20.0, -80.0), 15101))


def find_way(town: Town, start: Spot, target: TownPoint) -> tuple[list[Spot], list[int]] | None:
    """Find, by A*, a way to a pose with `target` one to two units straight ahead; None if there is none.

    Returns:
        The spots after each action, the start first, and the actions: 0 forward, 1 left, 2 right.
    """
    far = town.distances(target)

    def rest(spot: Spot) -> float:
        place = spot.place
        # Not a lower bound, as right-angled ways are not shortest: any good way is sufficient.
        return 0.9 * far.get((round(place.across), round(place.along)), 99)

    def key(spot: Spot) -> tuple[int, int, int]:
        place = spot.place
        return round(place.across / 0.4), round(place.along / 0.4), spot.heading

    order = count()
    waiting: list[tuple[float, int, float, Spot]] = [(rest(start), next(order), 0.0, start)]
    came: dict[Spot, tuple[Spot, int]] = {}
    closed = set()
    while waiting:
        _, _, cost, spot = heapq.heappop(waiting)
        right, ahead = spot.local(target)
        if abs(right) <= 0.35 and 1.0 <= ahead <= 1.9:
            return _trace(came, start, spot)
        if key(spot) in closed:
            continue
        closed.add(key(spot))
        for action, after in ((0, spot.ahead()), (1, spot.turned(-1)), (2, spot.turned(1))):
            price = _price(town, spot, after) if action == 0 else 0.6
            if price is not None and key(after) not in closed and after not in came and after != start:
                came[after] = (spot, action)
                heapq.heappush(waiting, (cost + price + rest(after), next(order), cost + price, after))
    return None


def _price(town: Town, spot: Spot, after: Spot) -> float | None:
    """Return the cost of a step: higher along walls; None if it is blocked."""
    here, there = spot.place, after.place
    middle = TownPoint((here.across + there.across) / 2, (here.along + there.along) / 2)
    room = min(town.clearance(there), town.clearance(middle))
    return None if room < 0.7 else 1.0 if room >= 1.0 else 1.3


def _trace(came: dict[Spot, tuple[Spot, int]], start: Spot, end: Spot) -> tuple[list[Spot], list[int]]:
    spots, actions = [end], []
    while spots[-1] != start:
        before, action = came[spots[-1]]
        spots.append(before)
        actions.append(action)
    return spots[::-1], actions[::-1]
