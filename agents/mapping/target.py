"""The target object of a navigation instruction: choosing the landmark that it is, and checking the pick-up range."""

import math

import numpy as np
import numpy.typing as npt

from arramon_agents.mapping.body import AgentBody
from arramon_agents.mapping.landmark_memory import MappedLandmark
from arramon_agents.mapping.motion import TURN
from arramon_agents.mapping.walk_kernel import pick_up_offset
from arramon_lang.meaning import Thing

REFERENCE_DISTANCE, REFERENCE_BUILDING_DISTANCE = 4.5, 9.0
"""Maximum distance of the target from its reference object, in units: from a thing, from a building."""

RESEMBLING_DISTANCE = 8.0
"""Maximum distance of an object that resembles the target from the end of the walk, in units."""


def find_target(body: AgentBody, wanted: Thing, missed: set[tuple[float, float]]) -> MappedLandmark | None:
    """Return the landmark that is most likely the target, except those at `missed` places; None if there is none."""
    fitting = [mark for mark in body.landmarks.matching(wanted) if (mark.x, mark.z) not in missed]
    if not fitting:
        return None
    near = [thing for where in wanted.where for thing in where.things]

    def cost(mark: MappedLandmark) -> tuple[bool, float, float]:
        cost = body.distance(mark.x, mark.z)
        for thing in near:
            others = body.landmarks.matching(thing)
            cost += min([20.0, *(2.0 * math.hypot(o.x - mark.x, o.z - mark.z) for o in others)])
        return not is_near_reference(body, wanted, mark), cost, mark.x

    return min(fitting, key=cost)


def find_resembling(
    body: AgentBody, wanted: Thing, missed: set[tuple[float, float]], place: tuple[float, float]
) -> MappedLandmark | None:
    """Return the object within RESEMBLING_DISTANCE of a place that is like the target in all but one attribute.

    A kind, colour or pattern may have been misread in the text or misseen. None if there is no such object, except at
    `missed` places. Objects near the target's reference object come first, then those nearest to the place.
    """
    fitting = [
        mark
        for mark in body.landmarks.matching(Thing(""))
        if (mark.x, mark.z) not in missed
        and math.dist((mark.x, mark.z), place) <= RESEMBLING_DISTANCE
        and _differences(wanted, mark) <= 1
    ]

    def cost(mark: MappedLandmark) -> tuple[bool, float, float]:
        return not is_near_reference(body, wanted, mark), math.dist((mark.x, mark.z), place), mark.x

    return min(fitting, key=cost, default=None)


def _differences(wanted: Thing, mark: MappedLandmark) -> int:
    """Return the number of given attributes of a thing that a landmark does not have."""
    label = mark.label
    pairs = (wanted.kind, label.kind), (wanted.colour, label.colour), (wanted.look, label.look)
    return sum(given not in ("", known) for given, known in pairs)


def is_near_reference(body: AgentBody, wanted: Thing, mark: MappedLandmark) -> bool:
    """Return whether a landmark is near a reference object of the target; True if the target has none."""
    if not wanted.where:
        return True
    things = [thing for where in wanted.where for thing in where.things]
    return any(
        math.hypot(other.x - mark.x, other.z - mark.z)
        <= (REFERENCE_BUILDING_DISTANCE if thing.kind == "building" else REFERENCE_DISTANCE)
        for thing in things
        for other in body.landmarks.matching(thing)
        if other is not mark
    )


def has_seen_reference(body: AgentBody, wanted: Thing) -> bool:
    """Return whether a landmark has been seen that may be a reference object of the target."""
    return any(body.landmarks.matching(thing) for where in wanted.where for thing in where.things)


def is_reached(body: AgentBody, target: MappedLandmark, x: float, z: float, heading: int) -> bool:
    """Return whether a pick-up at a pose takes the target and no other object; heading in multiples of 30 degrees."""
    angle = heading * TURN
    place = np.array((target.x, target.z))
    return pick_up_offset(place, other_objects(body, target), x, z, math.sin(angle), math.cos(angle)) >= 0.0


def other_objects(body: AgentBody, target: MappedLandmark) -> npt.NDArray[np.float64]:
    """Return (n, 2) of (x, z): places of the objects seen, except the target."""
    others = [(each.x, each.z) for each in body.landmarks.matching(Thing("")) if each is not target]
    return np.array(others, np.float64).reshape(-1, 2)
