"""Gate checks of streets: whether a street, crossing or corner is the one that a walker would take it for."""

import math
from collections.abc import Iterator

from arramon_client.world import turn_between
from arramon_dataset.instructions.gate.world import GateWorld
from arramon_dataset.paths import direction
from arramon_dataset.plans.graph import ROADS, Junction
from arramon_lang.meaning import Rotate, Step, Thing

COME_TO = 4.5
"""Maximum distance of the path from the open ground of a junction that it reaches, in units."""

CORNER_NEAR = 5.0
"""Maximum distance of the path from the corner of a building that it passes, in units."""

ASIDE = (40.0, 140.0)
"""Range of the angle between the path and a street that opens on one side, in degrees."""

OPENING_NEAR = 3.0
"""Maximum distance of the path from an opening between buildings that it passes, in units."""

BEYOND_TURN = 20.0
"""Minimum difference between a thing's angles to the path before and after a turn for it to lie beyond, in degrees."""

TURNED_NEAR, OTHER, ROUGHLY = 3.0, 40.0, 15.0
"""Maximum distance of a turn from the open ground of a junction whose streets are alternatives, in units; minimum
angle between such a street and the path, and accuracy with which people turn around, in degrees."""

SIDES = {"left": -1.0, "right": 1.0}

ORDINALS = {"first": 1, "second": 2, "third": 3}


def faults_of_place(world: GateWorld, since: int, thing: Thing, step: Step) -> Iterator[str]:
    """Yield each place with the same name that the path reaches before the intended one.

    Args:
        world: the gate's view of the turn.
        since: index of the path's place where the step begins; earlier if streets that open there count.
        thing: an intersection, T-junction, square or corner without an ordinal.
        step: the one that mentions it.
    """
    if world.graph is None or thing.which:
        return
    if thing.kind == "building_corner":
        yield from _earlier_corners(world, since, thing)
        return
    own = world.junction(thing.identity)
    near = None if own is None else world.geometry.first_approach(own.x, own.z, max(since, 0), own.radius + COME_TO)
    if near is None:
        return
    is_turn = isinstance(step, Rotate) and step.at == "at" and thing.kind != "corner"
    side = SIDES.get(step.direction) if isinstance(step, Rotate) and is_turn else None
    for other in world.graph.junctions:
        at = world.geometry.first_approach(other.x, other.z, max(since, 0), other.radius + 1.0)
        if at is None or other is own or len(other.arms) < 3 or not since + 1 < at < near - 2:
            continue
        if side is None or _opens(world, other, at, side):
            yield f"{other.identity} comes before the {thing.kind} {thing.identity}"


def _opens(world: GateWorld, junction: Junction, at: int, side: float) -> bool:
    before = world.geometry.heading_before(max(at - 2, 0))
    return any(ASIDE[0] <= side * turn_between(before, arm.heading) <= ASIDE[1] for arm in junction.arms)


def _earlier_corners(world: GateWorld, since: int, thing: Thing) -> Iterator[str]:
    """Yield each corner of a building with the same look that the path passes before the intended one."""
    own = world.corner(thing.identity)
    near = None if own is None else world.geometry.first_approach(own.x, own.z, max(since, 0), CORNER_NEAR)
    if own is None or near is None or world.graph is None:
        return
    looks = {building.identity for building in world.graph.buildings if building.look == thing.look}
    for building in (building for building in world.graph.buildings if building.identity in looks):
        for x, z in building.corners:
            at = world.geometry.first_approach(x, z, max(since, 0), CORNER_NEAR)
            if at is not None and since < at < near - 1 and math.dist((x, z), (own.x, own.z)) > 1.0:
                yield f"a corner of {building.identity} comes before {thing.identity}"


def faults_of_street(world: GateWorld, since: int, thing: Thing, direction: str, index: int) -> Iterator[str]:
    """Yield whether a turn enters another street than the named one, or one with another ordinal."""
    road = world.road(thing.identity)
    after = world.path[min(index + 4, len(world.path) - 1)]
    if road is None or road.distance(*after) > road.width / 2 + 1.5:
        yield f"the path does not turn into {thing.identity}"
    elif world.graph is not None and thing.which in ("", *ORDINALS):
        count = len(passed_arms(world, since, direction, index, thing.kind))
        if count != ORDINALS.get(thing.which, min(count, 1)):
            yield f"{thing.identity} is number {count} on the {direction}, not the {thing.which or 'first'}"
        most = 1 + max(_earlier_arms(world, since, direction, index), _earlier_openings(world, since, direction, index))
        if most > ORDINALS.get(thing.which, 1):
            yield f"{thing.identity} may be number {most} on the {direction}, not the {thing.which or 'first'}"


def faults_of_turn_by(world: GateWorld, since: int, step: Rotate, near: int, index: int) -> Iterator[str]:
    """Yield each street that also fits a turn before or after a thing.

    Args:
        world: the gate's view of the turn.
        since: index of the path's place where the step begins.
        step: with a thing.
        near: index of the place that is nearest to the thing.
        index: of the place of the turn.
    """
    if world.graph is None or step.direction not in SIDES or step.at == "at":
        return
    first, last = (since, index - 3) if step.at == "before" else (near, index - 3)
    own = _junctions_at(world, index)
    if step.at == "before" and any(_opens(world, each, index, SIDES[step.direction]) for each in own):
        return  # This is the last street before the thing.
    passed = {arm for kind in ROADS for arm in passed_arms(world, first, step.direction, last, kind)}
    for arm in sorted(passed):
        if not any(arm.startswith(f"{each.identity} ") for each in own):
            yield f"one may turn {step.direction} at {arm}, {step.at} {step.thing.identity if step.thing else ''}"


def faults_of_heading(world: GateWorld, index: int, degrees: float) -> Iterator[str]:
    """Yield each street that fits a turn by this many degrees better than the path does."""
    exact = world.geometry.heading_before(index) + degrees
    onward = world.geometry.heading_after(index)
    off = abs(turn_between(exact, onward)) + (ROUGHLY if abs(degrees) == 180.0 else 0.0)
    for junction in () if world.graph is None else world.graph.junctions:
        if math.dist((junction.x, junction.z), world.path[index]) > junction.radius + TURNED_NEAR:
            continue
        for arm in junction.arms:
            if abs(turn_between(onward, arm.heading)) > OTHER and abs(turn_between(exact, arm.heading)) < off:
                yield f"one may turn into {arm.road} at {junction.identity} instead"


def faults_of_turn_on_the_way(world: GateWorld, since: int, direction: str, index: int) -> Iterator[str]:
    """Yield whether a turn without a landmark, on the way towards something, could be made earlier."""
    if world.graph is not None and direction in SIDES and _earlier_arms(world, since, direction, index):
        yield f"one may turn {direction} before the path's place {index}"


def is_beyond_turn(world: GateWorld, x: float, z: float, index: int) -> bool:
    """Return whether (x, z) lies along the street entered by a turn, not ahead of the turn."""
    here = world.path[index]
    towards = direction(here, (x, z))
    off_before = abs(turn_between(world.geometry.heading_before(index), towards))
    return abs(turn_between(world.geometry.heading_after(index), towards)) < off_before - BEYOND_TURN


def _earlier_arms(world: GateWorld, since: int, direction: str, index: int) -> int:
    """Return how many streets and alleys a walker may count on one side before a turn, at most."""
    own = _junctions_at(world, index)
    passed = {arm for kind in ROADS for arm in passed_arms(world, since, direction, index - 2, kind, COME_TO)}
    return sum(not any(arm.startswith(f"{each.identity} ") for each in own) for arm in passed)


def _junctions_at(world: GateWorld, index: int) -> list[Junction]:
    listed = () if world.graph is None else world.graph.junctions
    return [each for each in listed if math.dist((each.x, each.z), world.path[index]) <= each.radius + 2.0]


def _earlier_openings(world: GateWorld, since: int, direction: str, index: int) -> int:
    """Return how many openings between buildings, streets or not, the path passes on one side before a turn."""
    passed: list[int] = []
    for landmark in world.all_landmarks:
        if landmark.label.kind == "intersection" and landmark.label.look == direction:
            near = world.geometry.first_approach(landmark.x, landmark.z, max(since, 0), OPENING_NEAR)
            if near is not None and since + 1 <= near < index - 3 and all(abs(near - each) > 3 for each in passed):
                passed.append(near)
    return len(passed)


def passed_arms(world: GateWorld, since: int, direction: str, index: int, kind: str, near_by: float = 1.0) -> set[str]:
    """Return the streets of a kind that open on one side of the path between two of its places, inclusive.

    Args:
        world: the gate's view of the turn.
        since, index: of the two places.
        direction: "left" or "right".
        kind: "street" or "alley".
        near_by: maximum distance of the path from the open ground of a junction that counts, in units.
    """
    found = set()
    assert world.graph is not None
    for junction in world.graph.junctions:
        near = world.geometry.first_approach(junction.x, junction.z, max(since, 0), junction.radius + near_by)
        if near is None or near > index + 2 or near < since + 1:
            continue
        before = world.geometry.heading_before(min(max(near - 2, 0), max(index - 2, 0)))
        for arm in junction.arms:
            right = turn_between(before, arm.heading) * SIDES[direction]
            if ASIDE[0] <= right <= ASIDE[1] and world.graph.road(arm.road).kind == kind:
                found.add(f"{junction.identity} {arm.road}")
    return found
