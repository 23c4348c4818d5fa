"""Gate checks of turns: the path must turn where an instruction says so, by about that angle, and nowhere else."""

import math
from collections.abc import Iterator
from dataclasses import replace

from arramon_client.world import turn_between
from arramon_dataset.instructions.gate.progress import HINDSIGHT, GateProgress, middle_of, nearest_index
from arramon_dataset.instructions.gate.streets import (
    faults_of_heading,
    faults_of_street,
    faults_of_turn_by,
    is_beyond_turn,
)
from arramon_dataset.instructions.gate.world import GateWorld
from arramon_dataset.path_tolerances import (
    ACCEPTED_AT,
    ACCEPTED_FACED,
    ACCEPTED_TURN_AT,
    ACCEPTED_UNMENTIONED,
    ACCEPTED_WIDE_SLIGHT,
)
from arramon_dataset.paths import PEAK, direction
from arramon_lang.meaning import PLACES, Rotate, Thing
from arramon_lang.street_words import DEGREES

TURN_REACH = 4
"""Maximum number of places between a turn and the place nearest to the thing that marks it."""

GOES_ON, BACK_WITHIN = 5, 15.0
"""Number of places before and after a slight turn within which the path must not turn back to within so many degrees:
otherwise it is only a sidestep."""

MENTION_REACH = 8
"""Maximum number of places between a wide bend and the mention of its turn."""

AT_GOAL = 5.0
"""Maximum distance from the target of a bend that need not be mentioned, in units."""

AGAIN = range(2, 6)
"""Places after a turn to one side where a second bend of that size would go unmentioned."""

BACK = 10
"""Number of places after a bend from which on no later step can mention it."""


def faults_of_face(world: GateWorld, progress: GateProgress, thing: Thing) -> Iterator[str]:
    """Yield the faults of an instruction to face a thing."""
    (x, z), here = middle_of(world, (thing,), progress.at), world.path[progress.at]
    towards = direction(here, (x, z))
    if abs(turn_between(world.geometry.heading_after(progress.at), towards)) > ACCEPTED_FACED:
        yield f"the path does not continue towards {thing.identity}"
    if thing.kind in PLACES:
        yield f"{thing.identity} is a place: what to face is ambiguous"


def check_turn(world: GateWorld, progress: GateProgress, step: Rotate, faults: list[str]) -> GateProgress:
    """Return the progress after a turn; its faults are added to `faults`."""
    degrees = DEGREES[step.direction]
    if step.thing is None:
        index = world.turn_near(progress.at, degrees, TURN_REACH)
        if index is None:
            faults.append(f"the path does not turn {step.direction} after its place {progress.at}")
            return progress
        if abs(degrees) >= 90.0:
            faults += faults_of_heading(world, index, degrees)
        return _turn_at(world, progress, index, degrees, faults)
    near = nearest_index(world, (step.thing,), progress.at, ACCEPTED_AT)
    reach = TURN_REACH + (3 if step.thing.kind in PLACES else 0)
    index = None if near is None else world.turn_near(near, degrees, reach)
    landmarks = world.landmarks(step.thing.identity)
    apart = (
        [math.dist((landmark.x, landmark.z), world.path[index]) for landmark in landmarks] if index is not None else []
    )
    if near is None or index is None or (step.at == "at" and min(apart, default=0.0) > ACCEPTED_TURN_AT):
        faults.append(f"the path does not turn {step.direction} {step.at} {step.thing.identity}")
        return progress
    if step.thing.kind in ("street", "alley"):
        faults += faults_of_street(world, progress.first_alternative, step.thing, step.direction, index)
    elif step.thing.kind not in PLACES:
        faults += faults_of_turn_by(world, progress.at, step, near, index)
    if step.at == "before" and any(is_beyond_turn(world, landmark.x, landmark.z, index) for landmark in landmarks):
        faults.append(f"{step.thing.identity} lies in the street after the turn")
    return _turn_at(world, progress, index, degrees, faults)


def _turn_at(world: GateWorld, progress: GateProgress, index: int, degrees: float, faults: list[str]) -> GateProgress:
    if abs(degrees) < 90.0 and not _is_slight(world, progress, index, degrees):
        faults.append(f"the path does not turn slightly at its place {index}, or only for a few paces")
    if index < progress.passed:
        faults.append(f"the path turns at its place {index}, before it passes the thing whose side is stated")
    if index in progress.turned:
        faults.append(f"the path turns only once at its place {index}, not twice")
    if abs(degrees) == 90.0 and any(_bends_again(world, index + later, degrees) for later in AGAIN):
        faults.append(f"the path turns again soon after its place {index}, which is not mentioned")
    return replace(progress, at=max(progress.at, index), turned=(*progress.turned, index))


def _bends_again(world: GateWorld, index: int, degrees: float) -> bool:
    """Return whether the path bends at once at a place, to the side of a turn, by more than may go unmentioned."""
    if index >= len(world.path) - 1 or _sees_goal(world, index):
        return False
    bend = turn_between(world.geometry.heading_of_move(index - 1), world.geometry.heading_of_move(index))
    return math.copysign(1.0, degrees) * bend > ACCEPTED_UNMENTIONED


def _is_slight(world: GateWorld, progress: GateProgress, index: int, degrees: float) -> bool:
    """Return whether the wide bend at a place is slight, or cannot be measured there."""
    if _is_sidestep(world, index, degrees):
        return False
    if any(0 < abs(index - each) <= MENTION_REACH for each in progress.mentioned_turns):
        return True
    measured = (world.geometry.wide_bends[at] for at in world.geometry.places_around(index, PEAK))
    wide = [math.copysign(1.0, degrees) * each for each in measured if each is not None]
    own = world.geometry.wide_bends[index]
    return own is None or (
        math.copysign(1.0, degrees) * own >= ACCEPTED_WIDE_SLIGHT[0] and max(wide) <= ACCEPTED_WIDE_SLIGHT[1]
    )


def _is_sidestep(world: GateWorld, index: int, degrees: float) -> bool:
    """Return whether a slight turn is only the beginning or the end of a sidestep."""
    sign = math.copysign(1.0, degrees)
    came, goes = world.geometry.heading_of_move(index - PEAK), world.geometry.heading_of_move(index + 1)
    after = (
        world.geometry.heading_of_move(at) for at in range(index + 2, min(index + 1 + GOES_ON, len(world.path) - 1))
    )
    before = (world.geometry.heading_of_move(at) for at in range(max(index - 1 - GOES_ON, 0), index - PEAK))
    return any(sign * turn_between(came, each) < BACK_WITHIN for each in after) or any(
        sign * turn_between(each, goes) < BACK_WITHIN for each in before
    )


def faults_of_bends(world: GateWorld, progress: GateProgress, *, is_end: bool) -> Iterator[str]:
    """Yield each bend of the path that no step mentioned; before the end, only those too far back to be mentioned."""
    until = len(world.path) if is_end else progress.at - BACK
    for at, angle in world.geometry.bends.items():
        if at >= until or abs(angle) <= ACCEPTED_UNMENTIONED or at in progress.turned:
            continue
        if not any(abs(at - faced) <= PEAK for faced in progress.faced) and not _sees_goal(world, at):
            yield f"the path turns by {angle:.0f} degrees at its place {at}, which is not mentioned"
    for at, wide in enumerate(world.geometry.wide_bends[: max(until if is_end else until - MENTION_REACH, 0)]):
        if (
            wide is None
            or abs(wide) <= ACCEPTED_UNMENTIONED
            or any(abs(at - each) <= MENTION_REACH for each in progress.mentioned_turns)
        ):
            continue
        if not _sees_goal(world, at):
            yield f"the path turns by {wide:.0f} degrees altogether around its place {at}, which is not mentioned"
            return


def _sees_goal(world: GateWorld, at: int) -> bool:
    """Return whether the target is near a place of the path, and visible before the path turns there."""
    if math.dist(world.path[at], world.goal) > AT_GOAL:
        return False
    targets = [landmark for landmark in world.all_landmarks if (landmark.x, landmark.z) == world.goal]
    return not world.poses or any(world.is_visible(landmark, at - HINDSIGHT, at - 1) for landmark in targets)
