"""The gate for walks: that the path leads to, past, along or between what one is told to walk by."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

from arramon_client.world import turn_between
from arramon_dataset.instructions.gate.progress import AT, BY, GateProgress, middle, nearest, places_ahead
from arramon_dataset.instructions.gate.sides import faults_of_passing, faults_of_side, poses_of_part
from arramon_dataset.instructions.gate.turns import TURN_REACH
from arramon_dataset.instructions.gate.world import GateWorld
from arramon_lang.meaning import PLACES, Thing, Walk

STRAIGHT = 18.0
"""Maximum angle from the path of what one walks straight to, in degrees."""


def walk(world: GateWorld, progress: GateProgress, step: Walk, faults: list[str]) -> GateProgress:
    """Return the progress after a walk; what is wrong with it is added to `faults`."""
    if not step.things:
        return progress
    if step.way == "along":
        road = world.road(step.things[0].identity)
        ahead = places_ahead(world, progress.at, 12)
        if road is None or min(road.distance(*world.path[i]) for i in ahead) > road.width / 2:
            faults.append(f"{step.things[0].identity} is not walked along")
        return progress
    if step.straight and step.way in ("to", "towards", "until"):
        faults += _faults_of_straight(world, progress, step.things)
    if step.way in ("until", "towards"):
        return _approach(world, progress, step, faults)
    near = nearest(world, step.things, progress.at, BY if step.way in ("past", "beside") else AT)
    if near is None:
        faults.append(f"the path does not come {step.way} {step.things[0].identity}")
        return progress
    if step.side:
        faults += faults_of_side(world, progress.at, step)
    elif step.way == "past" and step.things[0].kind not in PLACES:
        faults += faults_of_passing(world, progress.at, step)
    if step.way == "between" and not _is_amid(world, step.things, progress.at, near):
        faults.append(f"the path does not lead between {step.things[0].identity} and {step.things[1].identity}")
    return replace(progress, at=max(progress.at, near))


def _approach(world: GateWorld, progress: GateProgress, step: Walk, faults: list[str]) -> GateProgress:
    x, z = middle(world, step.things, progress.at)
    here = math.dist(world.path[progress.at], (x, z))
    ahead = places_ahead(world, progress.at, 30)
    if min(math.dist(world.path[i], (x, z)) for i in ahead) > here - 1.0 and here > 3.5:
        faults.append(f"the path does not lead towards {step.things[0].identity}")
    if step.way == "until":
        return progress
    return replace(progress, at=max(progress.at, world.closest(x, z, progress.at, BY) or 0))


def _is_amid(world: GateWorld, things: Sequence[Thing], since: int, near: int) -> bool:
    """Return whether two things stand on both sides of the way, more beside each other than one behind another."""
    here = poses_of_part(world, since).get(near)
    if here is None:
        return False
    places = [here.local(mark.x, mark.z) for each in things for mark in world.landmarks(each.identity)]
    (right, along), (other, far) = min(places), max(places)
    return right < 0.0 < other and abs(right + other) <= 5.0 and abs(along - far) <= other - right


def _faults_of_straight(world: GateWorld, progress: GateProgress, things: Sequence[Thing]) -> Iterator[str]:
    """Yield what is wrong with a walk straight to things: that they are not ahead, or the way there bends."""
    (x, z), here = middle(world, things, progress.at), world.path[progress.at]
    towards = math.degrees(math.atan2(x - here[0], z - here[1]))
    is_turned = any(abs(progress.at - said) <= TURN_REACH for said in progress.told)
    heading = world.heading_after(progress.at) if is_turned else world.heading_before(progress.at)
    if math.dist(here, (x, z)) > 3.0 and abs(turn_between(heading, towards)) > STRAIGHT:
        yield f"{things[0].identity} is not straight ahead"
