"""What the gate knows of the world along a turn's path: things by identity, and how the path goes by a place."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from server.dataset.instructions.sight import Landmark
from server.dataset.plans.graph import Corner, Junction, Road, StreetGraph
from server.sim.geometry import Pose

Place = tuple[float, float]

STRIDE = 3
"""Places over which the path's direction is measured."""


@dataclass(frozen=True, eq=False)
class GateWorld:
    """A turn's world.

    Attributes:
        path: distinct positions of the ground truth.
        start: first pose.
        marks: all landmarks.
        goal: (x, z) of the target.
        graph: the section's streets; None without a plan.
    """

    path: Sequence[Place]
    start: Pose
    marks: Sequence[Landmark]
    goal: Place
    graph: StreetGraph | None

    def landmarks(self, identity: str) -> tuple[Landmark, ...]:
        """Return the landmarks of an identity, or of several that "+" joins; of places only those of the graph."""
        by_identity = {mark.identity: mark for mark in self.marks if mark.label.kind != "intersection"}
        return tuple(by_identity[each] for each in identity.split("+") if each in by_identity)

    def junction(self, identity: str) -> Junction | None:
        """Return the junction of an identity, or None."""
        listed = () if self.graph is None else self.graph.junctions
        return next((each for each in listed if each.identity == identity), None)

    def corner(self, identity: str) -> Corner | None:
        """Return the corner of an identity, or None."""
        listed = () if self.graph is None else self.graph.corners
        return next((each for each in listed if each.identity == identity), None)

    def road(self, identity: str) -> Road | None:
        """Return the road of an identity, or None."""
        listed = () if self.graph is None else self.graph.roads
        return next((each for each in listed if each.identity == identity), None)

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
        return _bearing(self.path[max(index - STRIDE, 0)], self.path[index])

    def heading_after(self, index: int) -> float:
        """Return the direction in which the path leaves one of its places, in degrees; at its end, that to the goal."""
        after = min(index + STRIDE, len(self.path) - 1)
        return _bearing(self.path[index], self.path[after] if after > index else self.goal)

    def turn_near(self, index: int, degrees: float, reach: int) -> int | None:
        """Return the index within `reach` places where the path turns most nearly by `degrees`; None if it does not.

        A right angle may be between 40 and 140 degrees, a slight turn between 10 and 65, and one around 110 or more.
        """
        low, high = {30.0: (10.0, 65.0), 90.0: (40.0, 140.0)}.get(abs(degrees), (110.0, 180.0))
        found = []
        for at in range(max(index - reach, 0), min(index + reach, len(self.path) - 1) + 1):
            turned = turn_between(self.heading_before(at), self.heading_after(at))
            is_so = low <= abs(turned) <= high and (abs(degrees) == 180.0 or turned * degrees > 0.0)
            if is_so:
                found.append((abs(abs(turned) - abs(degrees)), at))
        return min(found)[1] if found else None

    def side_of(self, x: float, z: float, index: int) -> float:
        """Return how far to the right of the path a place is, at one of the path's places, in units."""
        before = self.path[max(index - STRIDE, 0)]
        after = self.path[min(index + STRIDE, len(self.path) - 1)]
        heading = self.start.heading if before == after else _bearing(before, after)
        right, _ = Pose(*self.path[index], heading).local(x, z)
        return right


def turn_between(before: float, after: float) -> float:
    """Return the smallest turn from one heading to another, in degrees in [-180, 180), positive clockwise."""
    return (after - before + 180.0) % 360.0 - 180.0


def _bearing(start: Place, end: Place) -> float:
    return math.degrees(math.atan2(end[0] - start[0], end[1] - start[1])) % 360.0
