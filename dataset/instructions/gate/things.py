"""The gate for things: what an instruction calls them, where it says that they are, and whether one sees them."""

import math
from collections.abc import Iterator

from arramon_dataset.instructions.gate.progress import AT, BY, HINDSIGHT, GateProgress
from arramon_dataset.instructions.gate.sides import stands_on
from arramon_dataset.instructions.gate.streets import ORDINALS
from arramon_dataset.instructions.gate.world import GateWorld
from arramon_dataset.instructions.sight import Landmark
from arramon_dataset.plans.graph import Junction
from arramon_lang.meaning import PLACES, Thing, Where
from arramon_lang.street import COUNTED_ASIDE
from arramon_server.sim.geometry import Pose

NEAR = 4.0
"""Maximum distance of a target from the landmark that tells where it is, in units; BY for a building."""

VIEWS, OFF_RELATION = 5, 75.0
"""Last places of the path from all of which the target is on the told side of a thing, and maximum angle between that
side and where it is from there, in degrees."""

TWIN_NEAR = 6.0
"""Distance from an object that looks like the target within which nothing is called as what tells the target's place,
in units."""

ALIKE = {"bin": ("dumpster",)}
"""Kinds of things that may be taken for one of a kind."""

COLOURED = ("awning",)
"""Kinds that fronts of houses are painted with too: they are told by their colours."""

AHEAD = 70.0
"""Maximum angle from the path of several things that one has before oneself, in degrees."""

FORESIGHT = 3
"""Places of the path after the last step's end from which a thing may be recognised, if one is told of it without
coming nearer."""

LATELY = 9
"""Places of the path before one comes to a thing from which it is seen: not only far off, and behind a corner then."""

WALKED_OVER, SURELY_OVER = 3.0, 1.6
"""Maximum distances of the path from the middle of a zebra crossing that counts, in units; and of one that everybody
counts. What is farther than this, and no farther than COUNTED_ASIDE, some count and some do not."""


def faults_of_description(world: GateWorld, progress: GateProgress, thing: Thing) -> Iterator[str]:
    """Yield what a name says that is not so: kind, colour, look, number, ordinal."""
    if thing.kind in PLACES:
        yield from _faults_of_place_name(world, progress, thing)
        return
    marks = world.landmarks(thing.identity)
    if not marks:
        yield f"{thing.kind} {thing.identity!r} does not exist"
    if thing.kind in COLOURED and not thing.colour and thing.identity not in progress.named:
        yield f"{thing.identity} is not told by its colour"
    for mark in marks:
        label = mark.label
        if thing.kind != label.kind or thing.colour not in ("", label.colour) or thing.look not in ("", label.look):
            yield f"{thing.identity} is a {label}, not {thing.colour} {thing.look} {thing.kind}"
    if (thing.number == "two" and len(marks) != 2) or (thing.number == "several" and len(marks) < 2):
        yield f"{thing.identity} is {len(marks)}, not {thing.number}"
    if thing.which in ORDINALS and marks:
        place = _count(world, progress, thing, marks[0])
        if place != ORDINALS[thing.which]:
            yield f"{thing.identity} is number {place} of its kind, not the {thing.which}"
        if thing.kind == "zebra_crossing":
            yield from _doubtful_crossings(world, progress, marks[0])
    elif thing.which == "next" and marks:
        own = _passed(world, marks[0], progress.at + 1)
        others = [
            _passed(world, each, progress.at + 1)
            for each in world.marks
            if each is not marks[0] and each.identity not in progress.named and is_called(thing, each)
        ]
        if own is not None and any(place is not None and place < own for place in others):
            yield f"{thing.identity} is not the next of its kind"


def _count(world: GateWorld, progress: GateProgress, thing: Thing, mark: Landmark) -> int:
    """Return which of the fitting things along the way since the last turn a landmark is, from 1."""
    since = progress.last_turn
    own = _passed(world, mark, since)
    if own is None:
        return 0
    others = (each for each in world.marks if each is not mark and is_called(thing, each))
    places = (_passed(world, each, since) for each in others)
    return 1 + sum(place is not None and place <= own for place in places)


def _doubtful_crossings(world: GateWorld, progress: GateProgress, mark: Landmark) -> Iterator[str]:
    """Yield each zebra crossing beside the way since the last turn to one, which some count and some do not."""
    since = progress.last_turn
    own = _passed(world, mark, since)
    if own is None:
        return
    for other in world.marks:
        if other is mark or other.label.kind != "zebra_crossing":
            continue
        near = world.closest(other.x, other.z, since, COUNTED_ASIDE)
        if near is not None and near <= own and math.dist(world.path[near], (other.x, other.z)) > SURELY_OVER:
            yield f"{other.identity} lies beside the way to {mark.identity}, and may be counted"


def _passed(world: GateWorld, mark: Landmark, since: int) -> int | None:
    """Return the index where the path comes closest to a landmark that counts; None if it does not come near."""
    limit = WALKED_OVER if mark.label.kind == "zebra_crossing" else COUNTED_ASIDE
    return world.closest(mark.x, mark.z, since, limit)


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
    near = world.closest(junction.x, junction.z, progress.at, junction.radius + AT)
    if near is None:
        yield f"the path does not come to {thing.identity}"
    elif not _is_kind(junction, thing.kind, world.heading_before(max(near - 2, 0))):
        yield f"{thing.identity} is a {junction.kind}, not a {thing.kind}"


def _is_kind(junction: Junction, kind: str, heading: float) -> bool:
    """Return whether a junction may be called an intersection, and so on, by a walker who arrives with a heading."""
    if kind == "intersection":
        return len(junction.arms) >= 3
    if kind == "street_end":
        return junction.arm_towards(heading) is None
    if kind == "t_junction":
        return len(junction.arms) >= 3 and junction.arm_towards(heading) is None
    return junction.kind == "square" if kind == "square" else True


# Where it is


def faults_of_relations(world: GateWorld, progress: GateProgress, thing: Thing) -> Iterator[str]:
    """Yield what is said of where a thing is that is not so, or that another thing fits better."""
    marks = world.landmarks(thing.identity)
    for where in thing.where:
        for landmark in where.things:
            yield from faults_of_description(world, progress, landmark)
        others = [mark for landmark in where.things for mark in world.landmarks(landmark.identity)]
        if marks and any(stands_on(marks[0], other) for other in others):
            yield f"{thing.identity} stands on {where.things[0].identity}, not {where.relation} it"
        elif marks and others and not _holds(world, where, marks[0], others):
            yield f"{thing.identity} is not {where.relation} {where.things[0].identity}"
        elif marks and others and not _is_nearest(world, where.things[0], marks[0], others):
            yield f"another is nearer to {thing.identity} than {where.things[0].identity}"


def _holds(world: GateWorld, where: Where, mark: Landmark, others: list[Landmark]) -> bool:
    if min(_distance(mark, other) for other in others) > (BY if others[0].label.kind == "building" else NEAR):
        return False
    return all(_is_so_from(view, where.relation, mark, others[0]) for view in world.path[-VIEWS:])


def _is_so_from(view: tuple[float, float], relation: str, mark: Landmark, other: Landmark) -> bool:
    """Return whether one thing is left of another, and so on, to who looks at it from a place."""
    heading = math.degrees(math.atan2(mark.x - view[0], mark.z - view[1]))
    right, ahead = Pose(other.x, other.z, heading % 360.0).local(mark.x, mark.z)
    least = {"left_of": -right, "right_of": right, "in_front_of": -ahead, "behind": ahead}.get(relation)
    return least is None or least > math.cos(math.radians(OFF_RELATION)) * math.hypot(right, ahead)


def _is_nearest(world: GateWorld, thing: Thing, mark: Landmark, others: list[Landmark]) -> bool:
    """Return whether no other thing that is called the same is nearer to a landmark."""
    own = min(_distance(mark, other) for other in others)
    rivals = (each for each in world.marks if each not in others and each != mark and _may_be_called(thing, each))
    return all(_distance(mark, rival) > own for rival in rivals)


def faults_of_target(world: GateWorld, target: Thing) -> Iterator[str]:
    """Yield each other object in the street that what is said of the target fits as well."""
    own = world.landmarks(target.identity)
    for other in world.marks:
        if not own or other in own or not is_called(target, other):
            continue
        if not any(_stands_alone(world, where, other) for where in target.where):
            yield f"{target.identity} may be taken for {other.identity}"


def _stands_alone(world: GateWorld, where: Where, other: Landmark) -> bool:
    """Return whether nothing near an object is called as what a relation names."""
    return not any(
        _distance(mark, other) <= TWIN_NEAR for mark in world.marks for thing in where.things if is_called(thing, mark)
    )


# What can be seen


def faults_of_sight(world: GateWorld, progress: GateProgress, thing: Thing) -> Iterator[str]:
    """Yield each thing that cannot be recognised while the step is walked that has come to where one is."""
    at, since = progress.at, progress.since
    until = at - 1 if at > since else since + FORESIGHT
    is_seen = thing.kind not in PLACES or thing.kind == "building_corner"
    for mark in world.landmarks(thing.identity) if is_seen else ():
        if since not in progress.earlier:
            is_visible = world.is_visible(mark, max(since - HINDSIGHT, until - LATELY), until)
        else:  # What was seen before the turn may have been in another street.
            is_visible = (until - since <= LATELY and world.is_visible_on(mark, since)) or world.is_visible(
                mark, max(since + 1, until - LATELY), max(until, since + 1)
            )
        if not is_visible:
            yield f"{mark.identity} cannot be seen on the way to it"


def faults_of_rivals(world: GateWorld, progress: GateProgress, thing: Thing, *, is_faced: bool) -> Iterator[str]:
    """Yield each other thing of a name that is seen ahead, or as one turns, nearer than the one that is meant.

    So is one that the path passes before it, whenever it was seen.
    """
    marks, since = world.landmarks(thing.identity), progress.since
    if thing.kind in PLACES or thing.which or thing.number or not marks:
        return
    view = Pose(*world.path[since], world.heading_after(since))
    own = math.hypot(*view.local(marks[0].x, marks[0].z))
    meant = None if is_faced or thing.kind == "building" else world.closest(marks[0].x, marks[0].z, since, BY)
    for other in world.marks:
        if not _may_be_called(thing, other) or other in marks:
            continue
        right, ahead = view.local(other.x, other.z)
        is_ahead = is_faced or (ahead > 1.0 and abs(right) <= ahead)
        is_nearer = is_ahead and math.hypot(right, ahead) < own - (0.0 if is_faced else 2.0)
        if is_nearer and world.is_visible(other, since, since if is_faced else max(progress.at, since + FORESIGHT)):
            yield f"{other.identity} may be taken for {thing.identity}"
        elif meant is not None and other.glimpsed is not None:
            passed = world.closest(other.x, other.z, since + 1, COUNTED_ASIDE)
            if passed is not None and passed < meant - 2:
                yield f"the path passes {other.identity} before {thing.identity}"


def faults_of_several(world: GateWorld, progress: GateProgress, thing: Thing) -> Iterator[str]:
    """Yield each of several things that is not before the walker."""
    view = Pose(*world.path[progress.at], world.heading_after(progress.at))
    for mark in world.landmarks(thing.identity) if thing.number else ():
        right, ahead = view.local(mark.x, mark.z)
        if abs(math.degrees(math.atan2(right, ahead))) > AHEAD:
            yield f"{mark.identity} is not before one who is told of {thing.number}"


def is_called(thing: Thing, mark: Landmark) -> bool:
    """Return whether the words of a name fit a landmark."""
    label = mark.label
    return thing.kind == label.kind and thing.colour in ("", label.colour) and thing.look in ("", label.look)


def _may_be_called(thing: Thing, mark: Landmark) -> bool:
    """Return whether somebody may call a landmark by a name: a dumpster is a bin to many, most of all in Hindi."""
    return is_called(thing, mark) or mark.label.kind in ALIKE.get(thing.kind, ())


def _distance(one: Landmark, other: Landmark) -> float:
    return math.dist((one.x, one.z), (other.x, other.z))
