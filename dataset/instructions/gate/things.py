"""Gate checks of things: their names, their stated locations, and their visibility."""

import math
from collections.abc import Iterator

from arramon_dataset.instructions.gate.progress import HINDSIGHT, GateProgress
from arramon_dataset.instructions.gate.sides import is_on_crossing
from arramon_dataset.instructions.gate.streets import ORDINALS
from arramon_dataset.instructions.gate.world import GateWorld
from arramon_dataset.instructions.visible_landmarks import Landmark
from arramon_dataset.path_tolerances import (
    ACCEPTED_AT,
    ACCEPTED_BY,
    ACCEPTED_LAST_VIEWS,
    ACCEPTED_NEAR,
    ACCEPTED_RELATION_ANGLE,
    ACCEPTED_TWIN_GAP,
)
from arramon_dataset.paths import Place, offset_seen_from, relation_offset
from arramon_dataset.plans.graph import Junction
from arramon_lang.meaning import PLACES, Thing, Where
from arramon_lang.street_words import COUNTED_WITHIN
from arramon_server.sim.geometry import Pose

ALIKE = {"bin": ("dumpster",)}
"""By kind: other kinds that people may call by its name."""

COLOURED = ("awning",)
"""Kinds that facade textures show too: a name must state their colour."""

AHEAD = 70.0
"""Maximum angle between the path and each member of a group ahead, in degrees."""

FORESIGHT = 3
"""Number of places after the start of a step that does not advance from which its thing may be recognised."""

LATELY = 9
"""Number of places before a step's end within which its thing must be visible, not only from far away."""

WALKED_OVER, SURELY_OVER = 3.0, 1.6
"""Maximum distances of the path from the middle of a zebra crossing that counts, and of one that everybody counts, in
units. Whether those beyond, up to COUNTED_ASIDE, count is ambiguous."""


def faults_of_description(world: GateWorld, progress: GateProgress, thing: Thing) -> Iterator[str]:
    """Yield the false parts of a name: kind, colour, look, number, ordinal."""
    if thing.kind in PLACES:
        yield from _faults_of_place_name(world, progress, thing)
        return
    landmarks = world.landmarks(thing.identity)
    if not landmarks:
        yield f"{thing.kind} {thing.identity!r} does not exist"
    if thing.kind in COLOURED and not thing.colour and thing.identity not in progress.named:
        yield f"{thing.identity} is named without its colour"
    for landmark in landmarks:
        label = landmark.label
        if thing.kind != label.kind or thing.colour not in ("", label.colour) or thing.look not in ("", label.look):
            yield f"{thing.identity} is a {label}, not {thing.colour} {thing.look} {thing.kind}"
    if (thing.number == "two" and len(landmarks) != 2) or (thing.number == "several" and len(landmarks) < 2):
        yield f"{thing.identity} is {len(landmarks)}, not {thing.number}"
    if thing.which in ORDINALS and landmarks:
        place = _count(world, progress, thing, landmarks[0])
        if place != ORDINALS[thing.which]:
            yield f"{thing.identity} is number {place} of its kind, not the {thing.which}"
        if thing.kind == "zebra_crossing":
            yield from _doubtful_crossings(world, progress, landmarks[0])
    elif thing.which == "next" and landmarks:
        own = _passed(world, landmarks[0], progress.at + 1)
        others = [
            _passed(world, each, progress.at + 1)
            for each in world.of_kinds(thing.kind)
            if each is not landmarks[0] and each.identity not in progress.named and is_called(thing, each)
        ]
        if own is not None and any(place is not None and place < own for place in others):
            yield f"{thing.identity} is not the next of its kind"


def _count(world: GateWorld, progress: GateProgress, thing: Thing, landmark: Landmark) -> int:
    """Return the ordinal of a landmark among the matching things since the last turn, from 1; 0 if it is not passed."""
    since = progress.last_turn
    own = _passed(world, landmark, since)
    if own is None:
        return 0
    others = (each for each in world.of_kinds(thing.kind) if each is not landmark and is_called(thing, each))
    places = (_passed(world, each, since) for each in others)
    return 1 + sum(place is not None and place <= own for place in places)


def _doubtful_crossings(world: GateWorld, progress: GateProgress, landmark: Landmark) -> Iterator[str]:
    """Yield each zebra crossing since the last turn that a walker might or might not count."""
    since = progress.last_turn
    own = _passed(world, landmark, since)
    if own is None:
        return
    for other in world.of_kinds("zebra_crossing"):
        if other is landmark:
            continue
        near = world.geometry.first_approach(other.x, other.z, since, COUNTED_WITHIN)
        if near is not None and near <= own and math.dist(world.path[near], (other.x, other.z)) > SURELY_OVER:
            yield f"{other.identity} lies beside the way to {landmark.identity}, and may be counted"


def _passed(world: GateWorld, landmark: Landmark, since: int) -> int | None:
    """Return the index where the path passes a landmark closely enough to count it; None if it does not."""
    limit = WALKED_OVER if landmark.label.kind == "zebra_crossing" else COUNTED_WITHIN
    return world.geometry.first_approach(landmark.x, landmark.z, since, limit)


def _faults_of_place_name(world: GateWorld, progress: GateProgress, thing: Thing) -> Iterator[str]:
    if thing.kind in ("street", "alley"):
        road = world.road(thing.identity)
        if road is None or (thing.kind == "alley") != (road.kind == "alley"):
            yield f"{thing.identity} is no {thing.kind}"
        return
    if thing.kind == "building_corner":
        corner = world.corner(thing.identity)
        building = world.landmarks(corner.building) if corner is not None else ()
        if not building or building[0].label.look != thing.look:
            yield f"{thing.identity} is not the corner of a {thing.look} building"
        return
    junction = world.junction(thing.identity)
    if junction is None:
        if thing.kind != "corner":
            yield f"{thing.kind} {thing.identity!r} does not exist"
        return
    near = world.geometry.first_approach(junction.x, junction.z, progress.at, junction.radius + ACCEPTED_AT)
    if near is None:
        yield f"the path does not reach {thing.identity}"
    elif not _is_kind(junction, thing.kind, world.geometry.heading_before(max(near - 2, 0))):
        yield f"{thing.identity} is a {junction.kind}, not a {thing.kind}"


def _is_kind(junction: Junction, kind: str, heading: float) -> bool:
    """Return whether a name such as "intersection" fits a junction for a walker who arrives with a heading."""
    if kind == "intersection":
        return len(junction.arms) >= 3
    if kind == "street_end":
        return junction.arm_towards(heading) is None
    if kind == "t_junction":
        return len(junction.arms) >= 3 and junction.arm_towards(heading) is None
    return junction.kind == "square" if kind == "square" else True


# Stated locations


def faults_of_relations(world: GateWorld, progress: GateProgress, thing: Thing) -> Iterator[str]:
    """Yield each stated relation that does not hold, or whose landmark could be another, nearer thing."""
    landmarks = world.landmarks(thing.identity)
    for where in thing.where:
        for reference in where.things:
            yield from faults_of_description(world, progress, reference)
        others = [landmark for reference in where.things for landmark in world.landmarks(reference.identity)]
        if landmarks and any(is_on_crossing(landmarks[0], other) for other in others):
            yield f"{thing.identity} stands on {where.things[0].identity}, not {where.relation} it"
        elif landmarks and others and not _holds(world, where, landmarks[0], others):
            yield f"{thing.identity} is not {where.relation} {where.things[0].identity}"
        elif landmarks and others and not _is_nearest(world, where.things[0], landmarks[0], others):
            yield f"another is nearer to {thing.identity} than {where.things[0].identity}"


def _holds(world: GateWorld, where: Where, landmark: Landmark, others: list[Landmark]) -> bool:
    if min(_distance(landmark, other) for other in others) > (
        ACCEPTED_BY if others[0].label.kind == "building" else ACCEPTED_NEAR
    ):
        return False
    return all(_is_so_from(view, where.relation, landmark, others[0]) for view in world.path[-ACCEPTED_LAST_VIEWS:])


def _is_so_from(view: Place, relation: str, landmark: Landmark, other: Landmark) -> bool:
    """Return whether one thing is in a relation to another, as seen from a place."""
    right, behind = offset_seen_from(view, (landmark.x, landmark.z), (other.x, other.z))
    offset = relation_offset(relation, right, behind)
    least = math.cos(math.radians(ACCEPTED_RELATION_ANGLE)) * math.hypot(right, behind)
    return offset is None or offset[0] > least


def _is_nearest(world: GateWorld, thing: Thing, landmark: Landmark, others: list[Landmark]) -> bool:
    """Return whether no other thing that fits the name is nearer to a landmark."""
    own = min(_distance(landmark, other) for other in others)
    rivals = (each for each in _may_be_called(world, thing) if each not in others and each != landmark)
    return all(_distance(landmark, rival) > own for rival in rivals)


def faults_of_target(world: GateWorld, target: Thing) -> Iterator[str]:
    """Yield each other object in the street that fits the target's description."""
    own = world.landmarks(target.identity)
    for other in world.of_kinds(target.kind):
        if not own or other in own or not is_called(target, other):
            continue
        if not any(_stands_alone(world, where, other) for where in target.where):
            yield f"{target.identity} may be taken for {other.identity}"


def _stands_alone(world: GateWorld, where: Where, other: Landmark) -> bool:
    """Return whether nothing near an object fits the names in a relation."""
    return not any(
        _distance(landmark, other) <= ACCEPTED_TWIN_GAP
        for thing in where.things
        for landmark in world.of_kinds(thing.kind)
        if is_called(thing, landmark)
    )


# Visibility


def faults_of_visibility(world: GateWorld, progress: GateProgress, thing: Thing) -> Iterator[str]:
    """Yield each thing that cannot be recognised during the last step."""
    at, since = progress.at, progress.since
    until = at - 1 if at > since else since + FORESIGHT
    is_seen = thing.kind not in PLACES or thing.kind == "building_corner"
    for landmark in world.landmarks(thing.identity) if is_seen else ():
        if since not in progress.earlier:
            is_visible = world.is_visible(landmark, max(since - HINDSIGHT, until - LATELY), until)
        else:  # A sighting before the turn may have been in another street.
            is_visible = (until - since <= LATELY and world.is_visible_on(landmark, since)) or world.is_visible(
                landmark, max(since + 1, until - LATELY), max(until, since + 1)
            )
        if not is_visible:
            yield f"{landmark.identity} cannot be seen on the way to it"


def faults_of_confusable_things(
    world: GateWorld, progress: GateProgress, thing: Thing, *, is_faced: bool
) -> Iterator[str]:
    """Yield each other thing that fits a name and is visible nearer ahead, or nearer during a turn.

    Also yield each one that the path passes first, whenever it was seen.
    """
    landmarks, since = world.landmarks(thing.identity), progress.since
    if thing.kind in PLACES or thing.which or thing.number or not landmarks:
        return
    view = Pose(*world.path[since], world.geometry.heading_after(since))
    own = math.hypot(*view.local(landmarks[0].x, landmarks[0].z))
    meant = (
        None
        if is_faced or thing.kind == "building"
        else world.geometry.first_approach(landmarks[0].x, landmarks[0].z, since, ACCEPTED_BY)
    )
    for other in _may_be_called(world, thing):
        if other in landmarks:
            continue
        right, ahead = view.local(other.x, other.z)
        is_ahead = is_faced or (ahead > 1.0 and abs(right) <= ahead)
        is_nearer = is_ahead and math.hypot(right, ahead) < own - (0.0 if is_faced else 2.0)
        if is_nearer and world.is_visible(other, since, since if is_faced else max(progress.at, since + FORESIGHT)):
            yield f"{other.identity} may be taken for {thing.identity}"
        elif meant is not None and other.glimpsed is not None:
            passed = world.geometry.first_approach(other.x, other.z, since + 1, COUNTED_WITHIN)
            if passed is not None and passed < meant - 2:
                yield f"the path passes {other.identity} before {thing.identity}"


def faults_of_group(world: GateWorld, progress: GateProgress, thing: Thing) -> Iterator[str]:
    """Yield each member of a group that is not ahead of the walker."""
    view = Pose(*world.path[progress.at], world.geometry.heading_after(progress.at))
    for landmark in world.landmarks(thing.identity) if thing.number else ():
        right, ahead = view.local(landmark.x, landmark.z)
        if abs(math.degrees(math.atan2(right, ahead))) > AHEAD:
            yield f"{landmark.identity} is not ahead of the walker"


def is_called(thing: Thing, landmark: Landmark) -> bool:
    """Return whether a name matches a landmark; omitted attributes match anything."""
    label = landmark.label
    return thing.kind == label.kind and thing.colour in ("", label.colour) and thing.look in ("", label.look)


def _may_be_called(world: GateWorld, thing: Thing) -> Iterator[Landmark]:
    """Yield the landmarks for which people may use a name: many call a dumpster a bin, above all in Hindi."""
    alike = ALIKE.get(thing.kind, ())
    for landmark in world.of_kinds(thing.kind, *alike):
        if landmark.label.kind in alike or is_called(thing, landmark):
            yield landmark


def _distance(one: Landmark, other: Landmark) -> float:
    return math.dist((one.x, one.z), (other.x, other.z))
