"""The gate for sides: on which side of the way a thing is while one passes it, and what stands on a thing.

A side is told by the way's direction there and then: by that of the straight part of the path on which one passes the
thing, never by a mean over a bend. Who is told to pass a thing passes it before the next bend that is told.
"""

import math
from collections.abc import Iterator, Sequence

from arramon_dataset.instructions.gate.world import STRIDE, TOLD_BEND, GateWorld, Place
from arramon_dataset.instructions.sight import Landmark
from arramon_lang.meaning import Walk
from arramon_server.sim.assets.roadside import ZEBRA_LENGTH, ZEBRA_WIDTH
from arramon_server.sim.geometry import Pose

ASIDE, ASIDE_ZEBRA = 0.9, 3.0
"""Minimum distances from the path of what is "on your left", in units; the second of a zebra crossing: it is wide."""

BESIDE, BEHIND = 70.0, 125.0
"""Angles between the way and a thing from which, and up to which, one has it beside oneself, in degrees."""

SIDE_REACH = 7.0
"""Maximum distance of the path from what is on one's side, in units."""

STOOD_AT = 1.2
"""Maximum distance of the path from what one walks over or around, on neither side, in units."""

SINCE = 2
"""Places of the path before the one that the steps have come to, where what is told may begin already."""

BODY = 0.3
"""Distance from the edge of what lies on the ground within which a thing stands on it at least in part, in units."""


def faults_of_side(world: GateWorld, since: int, step: Walk) -> Iterator[str]:
    """Yield each thing that is not beside the walker on the side that is told, before the path bends again.

    Args:
        world: of its turn.
        since: index of the path's place where the step begins.
        step: past or beside something, with a side.
    """
    least = ASIDE_ZEBRA if step.things[0].kind == "zebra_crossing" else ASIDE
    for mark in (mark for thing in step.things for mark in world.landmarks(thing.identity)):
        sides = list(sides_of(world, since, mark))
        own = [right if step.side == "right" else -right for right in sides]
        if not any(right >= least for right in own) or any(right <= -least for right in own):
            yield f"{mark.identity} is not on the {step.side}"


def faults_of_passing(world: GateWorld, since: int, step: Walk) -> Iterator[str]:
    """Yield each thing that one does not come to have beside oneself, or stand at, before the path bends again.

    Args:
        world: of its turn.
        since: index of the path's place where the step begins.
        step: past something, on either side.
    """
    for mark in (mark for thing in step.things for mark in world.landmarks(thing.identity)):
        ground = ground_of(world, mark)
        places = [(pose.x, pose.z) for pose in poses_of_part(world, since).values()]
        is_reached = any(math.dist(nearest_place(ground, place), place) <= STOOD_AT for place in places)
        if not is_reached and not any(True for _ in sides_of(world, since, mark)):
            yield f"{mark.identity} is not passed before the path bends"


def sides_of(world: GateWorld, since: int, mark: Landmark) -> Iterator[float]:
    """Yield how far to the right of the way a thing is, at each place of a straight part where one has it beside one.

    Args:
        world: of its turn.
        since: index of a place on the part, which ends with the next bend that is told.
        mark: the thing.
    """
    ground = ground_of(world, mark)
    for here in poses_of_part(world, since).values():
        place = nearest_place(ground, (here.x, here.z))
        right, ahead = here.local(*place)
        if math.hypot(right, ahead) <= SIDE_REACH and BESIDE <= math.degrees(math.atan2(abs(right), ahead)) <= BEHIND:
            yield right


def poses_of_part(world: GateWorld, since: int) -> dict[int, Pose]:
    """Return the places of the path from one on to the next bend that is told, with the way's direction at each.

    The direction is that of the path around the place, as far as the straight part reaches: what lies beyond its bends
    does not count.

    Args:
        world: of its turn.
        since: index of the first place; those within SINCE before it count too, if they are on the same part.

    Returns:
        Poses by the index of their place.
    """
    found = {}
    strong = [at for at, angle in world.bends.items() if abs(angle) > TOLD_BEND]
    first = max((at for at in strong if at <= since), default=0)
    last = min((at for at in strong if at > since), default=len(world.path) - 1)
    for index in range(max(since - SINCE, first), last + 1):
        # The places beside a bend's sharpest one belong to the bend, where the part is long enough.
        inner = (first + 1, last - 1) if last - first > STRIDE + 1 else (first, last)
        before = max(min(index - STRIDE, inner[1] - STRIDE), inner[0])
        after = min(max(index + STRIDE, inner[0] + STRIDE), inner[1])
        found[index] = Pose(*world.path[index], world.heading_between(before, after))
    return found


def ground_of(world: GateWorld, mark: Landmark) -> Sequence[Place]:
    """Return the corners of a building, or the place of any other thing."""
    houses = () if world.graph is None else world.graph.houses
    return next((each.corners for each in houses if each.identity == mark.identity), ((mark.x, mark.z),))


def nearest_place(ground: Sequence[Place], place: Place) -> Place:
    """Return the place of an outline that is nearest to another place."""
    edges = zip(ground, (*ground[1:], ground[0]), strict=True)
    return min((_onto(place, start, end) for start, end in edges), key=lambda each: math.dist(each, place))


def stands_on(mark: Landmark, other: Landmark) -> bool:
    """Return whether a thing stands on another that lies on the ground, at least in part: on a zebra crossing."""
    if other.label.kind != "zebra_crossing":
        return False
    across, along = Pose(other.x, other.z, other.heading).local(mark.x, mark.z)
    return abs(across) <= ZEBRA_WIDTH / 2 + BODY and abs(along) <= ZEBRA_LENGTH / 2 + BODY


def _onto(place: Place, start: Place, end: Place) -> Place:
    """Return the place of a segment that is nearest to another place."""
    dx, dz = end[0] - start[0], end[1] - start[1]
    square = dx * dx + dz * dz
    share = ((place[0] - start[0]) * dx + (place[1] - start[1]) * dz) / square if square else 0.0
    share = min(max(share, 0.0), 1.0)
    return start[0] + share * dx, start[1] + share * dz
