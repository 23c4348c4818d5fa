"""Gate checks of walks: the path must go to, past, along or between the things that a step names."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

from arramon_client.world import turn_between
from arramon_dataset.instructions.gate.progress import GateProgress, middle_of, nearest_index, places_ahead
from arramon_dataset.instructions.gate.sides import faults_of_passing, faults_of_side, poses_of_part
from arramon_dataset.instructions.gate.turns import TURN_REACH
from arramon_dataset.instructions.gate.world import GateWorld
from arramon_dataset.path_tolerances import ACCEPTED_AT, ACCEPTED_BY, ACCEPTED_FAR, ACCEPTED_STRAIGHT
from arramon_dataset.paths import direction
from arramon_lang.meaning import PLACES, Thing, Walk


def check_walk(world: GateWorld, progress: GateProgress, step: Walk, faults: list[str]) -> GateProgress:
    """Return the progress after a walk; its faults are added to `faults`."""
    if not step.things:
        return progress
    if step.way == "along":
        road = world.road(step.things[0].identity)
        ahead = places_ahead(world, progress.at, 12)
        if road is None or min(road.distance(*world.path[i]) for i in ahead) > road.width / 2:
            faults.append(f"{step.things[0].identity} is not on the path")
        return progress
    if step.straight and step.way in ("to", "towards", "until"):
        faults += _faults_of_straight(world, progress, step.things)
    if step.far and step.way in ("to", "towards"):
        faults += _faults_of_far(world, progress, step.things)
    if step.way in ("until", "towards"):
        return _approach(world, progress, step, faults)
    near = nearest_index(
        world, step.things, progress.at, ACCEPTED_BY if step.way in ("past", "beside") else ACCEPTED_AT
    )
    if near is None:
        faults.append(f"the path does not come {step.way} {step.things[0].identity}")
        return progress
    if step.side:
        faults += faults_of_side(world, progress.at, step)
    elif step.way == "past" and step.things[0].kind not in PLACES:
        faults += faults_of_passing(world, progress.at, step)
    if step.way == "between" and not _is_amid(world, step.things, progress.at, near):
        faults.append(f"the path does not lead between {step.things[0].identity} and {step.things[1].identity}")
    passed = near if step.side else progress.passed
    return replace(progress, at=max(progress.at, near), passed=passed)


def _faults_of_far(world: GateWorld, progress: GateProgress, things: Sequence[Thing]) -> Iterator[str]:
    """Yield whether things described as in the distance are near."""
    if math.dist(world.path[progress.at], middle_of(world, things, progress.at)) < ACCEPTED_FAR:
        yield f"{things[0].identity} is not in the distance"


def _approach(world: GateWorld, progress: GateProgress, step: Walk, faults: list[str]) -> GateProgress:
    x, z = middle_of(world, step.things, progress.at)
    here = math.dist(world.path[progress.at], (x, z))
    ahead = places_ahead(world, progress.at, 30)
    if min(math.dist(world.path[i], (x, z)) for i in ahead) > here - 1.0 and here > 3.5:
        faults.append(f"the path does not lead towards {step.things[0].identity}")
    if step.way == "until":
        return progress
    return replace(progress, at=max(progress.at, world.geometry.first_approach(x, z, progress.at, ACCEPTED_BY) or 0))


def _is_amid(world: GateWorld, things: Sequence[Thing], since: int, near: int) -> bool:
    """Return whether two things stand on opposite sides of the path, rather beside than behind each other."""
    here = poses_of_part(world, since).get(near)
    if here is None:
        return False
    places = [here.local(landmark.x, landmark.z) for each in things for landmark in world.landmarks(each.identity)]
    (right, along), (other, far) = min(places), max(places)
    return right < 0.0 < other and abs(right + other) <= 5.0 and abs(along - far) <= other - right


def _faults_of_straight(world: GateWorld, progress: GateProgress, things: Sequence[Thing]) -> Iterator[str]:
    """Yield whether things described as straight ahead are not."""
    (x, z), here = middle_of(world, things, progress.at), world.path[progress.at]
    towards = direction(here, (x, z))
    is_turned = any(abs(progress.at - turn) <= TURN_REACH for turn in progress.mentioned_turns)
    heading = world.geometry.heading_after(progress.at) if is_turned else world.geometry.heading_before(progress.at)
    if math.dist(here, (x, z)) > 3.0 and abs(turn_between(heading, towards)) > ACCEPTED_STRAIGHT:
        yield f"{things[0].identity} is not straight ahead"
