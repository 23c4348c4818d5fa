"""What the gate knows of the world along a turn's path: things by identity, and how the path goes by a place."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from arramon_client.world import bearing, turn_between
from arramon_dataset.instructions.sight import Landmark
from arramon_dataset.plans.graph import Corner, Junction, Road, StreetGraph
from arramon_server.sim.geometry import Pose

Place = tuple[float, float]

STRIDE = 3
"""Places over which the path's direction is measured."""

TURNED = {30.0: (10.0, 48.0), 90.0: (44.0, 140.0), 180.0: (135.0, 180.0)}
"""Least and greatest bend that is called a turn by so many degrees, in degrees. The agent turns by multiples of 30: one
is a slight turn, two to four are one to a side, five and six are one around."""

BEND = 8.0
"""Minimum change of direction that is a bend, in degrees."""

PEAK = 2
"""Places on both sides of a bend's sharpest one that belong to it."""

TOLD_BEND = 37.0
"""A bend of the path by more degrees is told."""

FACING = 35.0
"""Maximum angle between the way on and a heading in which one looks along it, in degrees."""

WIDE_GAP, WIDE_STRIDE = 3, 5
"""Places on both sides of one that a wide bend leaves out, and places beyond them over which its directions are
measured."""


@dataclass(frozen=True, eq=False)
class GateWorld:
    """A turn's world.

    Attributes:
        path: distinct positions of the ground truth.
        start: first pose.
        marks: all landmarks.
        goal: (x, z) of the target.
        graph: the section's streets; None without a plan.
        poses: along the path, to which `Landmark.seen` refers; none if what is visible is not to be checked.
    """

    path: Sequence[Place]
    start: Pose
    marks: Sequence[Landmark]
    goal: Place
    graph: StreetGraph | None
    poses: Sequence[Pose] = ()

    def landmarks(self, identity: str) -> tuple[Landmark, ...]:
        """Return the landmarks of an identity, or of several that "+" joins; of places only those of the graph."""
        return tuple(self._by_identity[each] for each in identity.split("+") if each in self._by_identity)

    @cached_property
    def _by_identity(self) -> dict[str, Landmark]:
        return {mark.identity: mark for mark in self.marks if mark.label.kind != "intersection"}

    def junction(self, identity: str) -> Junction | None:
        """Return the junction of an identity, or None."""
        return self._junctions.get(identity)

    @cached_property
    def _junctions(self) -> dict[str, Junction]:
        return {} if self.graph is None else {each.identity: each for each in self.graph.junctions}

    def corner(self, identity: str) -> Corner | None:
        """Return the corner of an identity, or None."""
        return self._corners.get(identity)

    @cached_property
    def _corners(self) -> dict[str, Corner]:
        return {} if self.graph is None else {each.identity: each for each in self.graph.corners}

    def road(self, identity: str) -> Road | None:
        """Return the road of an identity, or None."""
        return self._roads.get(identity)

    @cached_property
    def _roads(self) -> dict[str, Road]:
        return {} if self.graph is None else {each.identity: each for each in self.graph.roads}

    def closest(self, x: float, z: float, since: int, limit: float) -> int | None:
        """Return the index where the path comes closest to (x, z), the first time that it is within `limit` of it."""
        best: int | None = None
        for index in range(since, len(self.path)):
            near = math.dist(self.path[index], (x, z))
            if near <= limit and (best is None or near < math.dist(self.path[best], (x, z))):
                best = index
            elif best is not None and near > math.dist(self.path[best], (x, z)) + 1.0:
                break
        return best

    def heading_before(self, index: int) -> float:
        """Return the direction in which the path arrives at one of its places, in degrees."""
        if index == 0:
            return self.start.heading
        return bearing(self.path[max(index - STRIDE, 0)], self.path[index])

    def heading_after(self, index: int) -> float:
        """Return the direction in which the path leaves one of its places, in degrees; at its end, that to the goal."""
        after = min(index + STRIDE, len(self.path) - 1)
        return bearing(self.path[index], self.path[after] if after > index else self.goal)

    def heading_between(self, first: int, last: int) -> float:
        """Return the direction of the path from a place to a later one, in degrees; that of its start without one."""
        return self.start.heading if first >= last else bearing(self.path[first], self.path[last])

    def heading_of_move(self, index: int) -> float:
        """Return the direction of the path from one of its places to the next, in degrees; before the first, its start.

        Args:
            index: of the place; one beyond the last that leads on counts as that.
        """
        if index < 0:
            return self.start.heading
        at = min(index, len(self.path) - 2)
        return self.start.heading if at < 0 else bearing(self.path[at], self.path[at + 1])

    @cached_property
    def bends(self) -> dict[int, float]:
        """Where the path turns, and by how many degrees, positive clockwise: at the sharpest place of each bend."""
        turned = [turn_between(self.heading_before(at), self.heading_after(at)) for at in range(len(self.path))]
        found: dict[int, float] = {}
        for at, angle in enumerate(turned):
            around = turned[max(at - PEAK, 0) : at + PEAK + 1]
            if abs(angle) >= BEND and abs(angle) >= max(each * math.copysign(1.0, angle) for each in around):
                found[at] = angle
        return found

    @cached_property
    def wide_bends(self) -> list[float | None]:
        """By how many degrees the path turns around each of its places; see `_wide_bend`."""
        return [self._wide_bend(index) for index in range(len(self.path))]

    def places_around(self, index: int, reach: int) -> range:
        """Return the indices of the places of the path that are within `reach` places of one."""
        return range(max(index - reach, 0), min(index + reach + 1, len(self.path)))

    def _wide_bend(self, index: int) -> float | None:
        """Return by how many degrees the path turns around a place, small bends of the way taken together.

        What is left and entered again within a few places, as around a barrier, is no wide bend.

        Returns:
            Degrees, positive clockwise; None near the path's ends.
        """
        before, after = index - WIDE_GAP, index + WIDE_GAP
        if before - WIDE_STRIDE < 0 or after + 2 >= len(self.path):
            return None
        last = min(after + WIDE_STRIDE, len(self.path) - 1)
        arrival = bearing(self.path[before - WIDE_STRIDE], self.path[before])
        return turn_between(arrival, bearing(self.path[after], self.path[last]))

    def turn_near(self, index: int, degrees: float, reach: int) -> int | None:
        """Return the index within `reach` places of the bend most nearly by `degrees`; None if there is none."""
        low, high = TURNED[abs(degrees)]
        found = [
            (abs(abs(angle) - abs(degrees)), at)
            for at, angle in self.bends.items()
            if abs(at - index) <= reach
            and low <= abs(angle) <= high
            and (abs(degrees) == 180.0 or angle * degrees > 0.0)
        ]
        return min(found)[1] if found else None

    def is_visible(self, mark: Landmark, first: int, last: int) -> bool:
        """Return whether a landmark is recognised from one of the path's places from `first` to `last`."""
        places = set(self.path[max(first, 0) : last + 1])
        return any(number >= 0 and (self.poses[number].x, self.poses[number].z) in places for number in mark.seen)

    def is_visible_on(self, mark: Landmark, index: int) -> bool:
        """Return whether a landmark is recognised from one of the path's places as one turns on to the next."""
        place, on = self.path[index], self.heading_after(index)
        return any(
            number >= 0
            and (self.poses[number].x, self.poses[number].z) == place
            and abs(turn_between(self.poses[number].heading, on)) <= FACING
            for number in mark.seen
        )
