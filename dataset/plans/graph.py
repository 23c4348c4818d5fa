"""A section's streets as a graph: junctions with their arms, roads, corners of blocks, and named buildings.

Everything is in the world frame. An identity is a string that is unique in its section and stable: the name of the
body in the scene where there is one ("building/3"), otherwise the kind and a number in the plan's order ("junction/0").
Sections that were reconstructed from paths have no plan, and so no graph.
"""

import math
from dataclasses import dataclass

from arramon_client.world import turn_between

JUNCTIONS = ("crossing", "t_junction", "fork", "bend", "street_end", "square")
"""Kinds of junctions: four arms or more; three, two of them in line; three, no two in line; two, at an angle; one; an
open square, with any number of streets."""

ROADS = ("street", "alley")

SIZES = ("", "tall", "small")
"""Sizes of buildings; "" for one that is neither."""

STRAIGHT = 35.0
"""Maximum angle between two arms and a straight line for the arms to count as in line, in degrees."""


@dataclass(frozen=True, slots=True)
class Arm:
    """A road that leaves a junction.

    Attributes:
        heading: direction away from the junction, degrees clockwise from +z.
        road: identity of the road.
        leads_to: identity of the next junction on it; "" if there is none.
        x, z: where the road's middle line leaves the junction's open ground.
    """

    heading: float
    road: str
    leads_to: str
    x: float
    z: float


@dataclass(frozen=True, slots=True)
class Junction:
    """A place where roads meet, bend or end.

    Attributes:
        identity: "junction/0" and so on.
        x, z: its centre, in units; free to walk on, like all roads' middle lines.
        kind: one of JUNCTIONS.
        arms: clockwise, by heading.
        radius: distance from the centre to the farthest start of an arm, in units.
    """

    identity: str
    x: float
    z: float
    kind: str
    arms: tuple[Arm, ...]
    radius: float

    def arm_towards(self, heading: float, tolerance: float = STRAIGHT) -> Arm | None:
        """Return the arm whose direction is nearest to a heading, or None if none is within `tolerance` degrees."""
        near = [arm for arm in self.arms if angle_between(arm.heading, heading) <= tolerance]
        return min(near, key=lambda arm: angle_between(arm.heading, heading), default=None)

    def kind_from(self, heading: float) -> str:
        """Return the kind of the junction as seen by a walker who arrives with this heading.

        A T-junction that is entered from its bar is "left_turn" or "right_turn", the side on which a street leaves;
        from its stem it is "t_junction": the street ends, and one goes left or right.
        """
        if self.kind not in ("t_junction", "bend"):
            return self.kind
        ahead = self.arm_towards(heading)
        back = self.arm_towards(heading + 180.0)
        sides = [arm for arm in self.arms if arm not in (ahead, back)]
        if self.kind == "t_junction" and ahead is None:
            return "t_junction"
        if len(sides) != 1:
            return self.kind
        return "right_turn" if turn_between(heading, sides[0].heading) > 0.0 else "left_turn"


@dataclass(frozen=True, slots=True)
class Road:
    """A street or an alley.

    Attributes:
        identity: "street/0" and so on, also for alleys, by the order in the plan.
        name: for people; no instruction uses it.
        kind: one of ROADS.
        width: between the facades, in units.
        line: (x, z) of its middle line's ends and bends.
        junctions: identities of the junctions on it, in order along the line.
    """

    identity: str
    name: str
    kind: str
    width: float
    line: tuple[tuple[float, float], ...]
    junctions: tuple[str, ...]

    def distance(self, x: float, z: float) -> float:
        """Return the distance of a place from the middle line, in units."""
        return min(_from_segment((x, z), start, end) for start, end in zip(self.line, self.line[1:], strict=False))


@dataclass(frozen=True, slots=True)
class Corner:
    """A corner of a block, between two neighbouring arms of a junction.

    Attributes:
        identity: "corner/0" and so on.
        x, z: the corner of the building there, in units.
        building: identity of that building.
        junction: identity of the junction.
    """

    identity: str
    x: float
    z: float
    building: str
    junction: str


@dataclass(frozen=True, slots=True)
class NamedBuilding:
    """A building with the attributes by which it can be named.

    Attributes:
        identity: "building/0" and so on, the name of its body.
        x, z: its centre, in units.
        corners: (x, z) of its four corners.
        colours: colour names that fit it, the likeliest first; a colour identifies it only where it fits no other
            building in view.
        look: its facade, one of `section.FACADES`.
        size: one of SIZES.
        sign: kind of shop on its sign; "" if it has none.
        roads: identities of the roads that it faces.
    """

    identity: str
    x: float
    z: float
    corners: tuple[tuple[float, float], ...]
    colours: tuple[str, ...]
    look: str
    size: str
    sign: str
    roads: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class StreetGraph:
    """All of a section's junctions, roads, corners and buildings."""

    junctions: tuple[Junction, ...]
    roads: tuple[Road, ...]
    corners: tuple[Corner, ...]
    buildings: tuple[NamedBuilding, ...]

    def junction(self, identity: str) -> Junction:
        """Return a junction by its identity.

        Raises:
            KeyError: if there is none.
        """
        for junction in self.junctions:
            if junction.identity == identity:
                return junction
        raise KeyError(identity)

    def road(self, identity: str) -> Road:
        """Return a road by its identity.

        Raises:
            KeyError: if there is none.
        """
        for road in self.roads:
            if road.identity == identity:
                return road
        raise KeyError(identity)

    def junction_at(self, x: float, z: float) -> Junction | None:
        """Return the junction whose open ground contains a place, the nearest of several; None if none does."""
        inside = [j for j in self.junctions if math.dist((j.x, j.z), (x, z)) <= j.radius]
        return min(inside, key=lambda j: math.dist((j.x, j.z), (x, z)), default=None)

    def roads_at(self, x: float, z: float) -> tuple[Road, ...]:
        """Return the roads that contain a place."""
        return tuple(road for road in self.roads if road.distance(x, z) <= road.width / 2)


def angle_between(one: float, other: float) -> float:
    """Return the angle between two headings, in degrees from 0 to 180."""
    return abs(turn_between(one, other))


def _from_segment(p: tuple[float, float], a: tuple[float, float], b: tuple[float, float]) -> float:
    dx, dz = b[0] - a[0], b[1] - a[1]
    square = dx * dx + dz * dz
    share = 0.0 if square == 0.0 else min(max(((p[0] - a[0]) * dx + (p[1] - a[1]) * dz) / square, 0.0), 1.0)
    return math.hypot(p[0] - a[0] - share * dx, p[1] - a[1] - share * dz)
