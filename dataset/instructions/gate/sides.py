"""Gate checks of sides: on which side of the path a thing is when passed, and what stands on a zebra crossing.

Sides refer to the direction of the straight part of the path on which the walker passes the thing, never to a mean over
a bend. A thing must be passed before the next bend that the instruction mentions.
"""

import math
from collections.abc import Iterator, Sequence

from arramon_dataset.instructions.gate.world import GateWorld
from arramon_dataset.instructions.visible_landmarks import Landmark
from arramon_dataset.path_tolerances import (
    ACCEPTED_ASIDE,
    ACCEPTED_ASIDE_ZEBRA,
    ACCEPTED_BESIDE,
    ACCEPTED_BY,
    ACCEPTED_UNMENTIONED,
    ACCEPTED_ZEBRA_MARGIN,
)
from arramon_dataset.paths import Place, nearest_on_outline
from arramon_lang.meaning import Walk
from arramon_server.sim.geometry import Pose

STOOD_AT = 1.2
"""Maximum distance of the path from a thing that counts as reached, on neither side, in units."""

SINCE = 2
"""Number of places before the current one that still count as part of the step."""


def faults_of_side(world: GateWorld, since: int, step: Walk) -> Iterator[str]:
    """Yield each thing that is not beside the walker on the stated side before the path bends again.

    Args:
        world: the gate's view of the turn.
        since: index of the path's place where the step begins.
        step: past or beside something, with a side.
    """
    least = ACCEPTED_ASIDE_ZEBRA if step.things[0].kind == "zebra_crossing" else ACCEPTED_ASIDE
    for landmark in (landmark for thing in step.things for landmark in world.landmarks(thing.identity)):
        sides = list(sides_of(world, since, landmark))
        own = [right if step.side == "right" else -right for right in sides]
        if not any(right >= least for right in own) or any(right <= -least for right in own):
            yield f"{landmark.identity} is not on the {step.side}"


def faults_of_passing(world: GateWorld, since: int, step: Walk) -> Iterator[str]:
    """Yield each thing that the path neither passes nor reaches before it bends again.

    Args:
        world: the gate's view of the turn.
        since: index of the path's place where the step begins.
        step: past something, on either side.
    """
    for landmark in (landmark for thing in step.things for landmark in world.landmarks(thing.identity)):
        ground = footprint_of(world, landmark)
        places = [(pose.x, pose.z) for pose in poses_of_part(world, since).values()]
        is_reached = any(math.dist(nearest_on_outline(ground, place), place) <= STOOD_AT for place in places)
        if not is_reached and not any(True for _ in sides_of(world, since, landmark)):
            yield f"{landmark.identity} is not passed before the path bends"


def sides_of(world: GateWorld, since: int, landmark: Landmark) -> Iterator[float]:
    """Yield how far to the right of the path a thing is, at each place of a straight part that is beside it.

    Args:
        world: the gate's view of the turn.
        since: index of a place on the part, which ends at the next bend that must be mentioned.
        landmark: the thing.
    """
    ground = footprint_of(world, landmark)
    for here in poses_of_part(world, since).values():
        place = nearest_on_outline(ground, (here.x, here.z))
        right, ahead = here.local(*place)
        angle = math.degrees(math.atan2(abs(right), ahead))
        if math.hypot(right, ahead) <= ACCEPTED_BY and ACCEPTED_BESIDE[0] <= angle <= ACCEPTED_BESIDE[1]:
            yield right


def poses_of_part(world: GateWorld, since: int) -> dict[int, Pose]:
    """Return the places of the path up to the next bend that must be mentioned, with the path's direction at each.

    Args:
        world: the gate's view of the turn.
        since: index of the first place; up to SINCE places before it are included if they are on the same part.

    Returns:
        Poses by the index of their place.
    """
    return world.geometry.straight_part(since, ACCEPTED_UNMENTIONED, SINCE)


def footprint_of(world: GateWorld, landmark: Landmark) -> Sequence[Place]:
    """Return the corners of a building, or the position of any other thing."""
    buildings = () if world.graph is None else world.graph.buildings
    return next((each.corners for each in buildings if each.identity == landmark.identity), ((landmark.x, landmark.z),))


def is_on_crossing(landmark: Landmark, other: Landmark) -> bool:
    """Return whether `other` is a zebra crossing on which a thing stands, at least partly."""
    return other.covers_ground(landmark.x, landmark.z, ACCEPTED_ZEBRA_MARGIN)
