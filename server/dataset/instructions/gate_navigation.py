"""The gate for navigation: every step and everything that an instruction names, held against path and world."""

import math
from collections.abc import Iterator
from dataclasses import replace

from lang.meaning import PLACES, Face, Navigation, Rotate, Step, Thing, Walk, Where
from lang.reference import things_of
from lang.street import COUNTED_ASIDE, DEGREES
from server.dataset.instructions.gate import faults_of_names
from server.dataset.instructions.gate_streets import (
    ORDINALS,
    faults_of_place,
    faults_of_street,
    faults_of_turn_by,
    is_beyond_turn,
)
from server.dataset.instructions.gate_world import PEAK, GateWorld, Place, turn_between
from server.dataset.instructions.sight import Landmark
from server.dataset.plans.graph import Junction
from server.sim.geometry import Pose

AT, BY, NEAR = 4.5, 7.0, 4.0
"""Maximum distances: of the path from what one turns at or walks to, from what one passes, and of a target from the
landmark that tells where it is, in units."""

TWIN_NEAR = 6.0
"""Distance from an object that looks like the target within which nothing is called as what tells the target's place,
in units."""

TURN_AT = 4.0
"""Maximum distance from a thing of a turn that is made at it, in units."""

TURN_REACH = 4
"""Places around the one nearest to a thing in which the path turns at it."""

SLIGHT_WIDE = (12.0, 50.0)
"""Least and greatest wide bend that is called a slight turn, in degrees."""

TOLD_NEAR = 8
"""Places of the path between a wide bend and what is said of a turn, if that is another one."""

COLOURED = ("awning",)
"""Kinds that fronts of houses are painted with too: they are told by their colours."""

TOLD_BEND, AT_GOAL = 43.0, 5.0
"""A bend of the path by more degrees is said, unless it is within this distance of the target, in units."""

ASIDE, ASIDE_ZEBRA = 0.9, 3.0
"""Minimum distances from the path of what is "on your left", in units; the second of a zebra crossing: it is wide."""

STRAIGHT, AHEAD = 18.0, 70.0
"""Maximum angles from the path of what one walks straight to, and of several things that one has before oneself, in
degrees."""

HINDSIGHT, FORESIGHT = 5, 3
"""Places of the path before the last step's end from which a thing may have been recognised; and after it, if one is
told of it without coming nearer."""

FACED = 40.0
"""Maximum angle between the way on and what one turns to face, in degrees."""

WALKED_OVER = 3.0
"""Maximum distance of the path from the middle of a zebra crossing that counts, in units."""

NOT_FIRST = ("intersection", "t_junction", "corner", "building_corner")
"""Kinds of places of which the first one on the way is meant."""


def faults_of_navigation(meaning: Navigation, world: GateWorld) -> tuple[str, ...]:
    """Return what an instruction says that is not so; nothing if all of it is true.

    Args:
        meaning: with the identity of everything that it names.
        world: of its turn.
    """
    return (*faults_of_names(meaning), *_Check(world).faults(meaning))


class _Check:
    """Follows a path through an instruction's steps.

    Attributes:
        at: index of the path's place that the steps so far have come to.
        turned: indices of the places where a turn has been said.
        faced: indices of those where one has been told what to face.
    """

    def __init__(self, world: GateWorld) -> None:
        self._world = world
        self.at = 0
        self.turned: list[int] = []
        self.faced: list[int] = []
        self._named: set[str] = set()

    def faults(self, meaning: Navigation) -> Iterator[str]:
        previous: Step | None = None
        for step in meaning.steps:
            since, things = self.at, things_of(step)
            if isinstance(previous, Face) and isinstance(step, Rotate) and step.at == "after":
                yield f"one faces {previous.thing.identity}, and is not told to walk before the turn"
            previous = step
            for thing in things:
                yield from self._described(thing)
                if thing.kind in NOT_FIRST:
                    yield from faults_of_place(self._world, self._last_choice(), thing, step)
                yield from self._related(thing)
                if thing.number:
                    yield from self._before_the_walker(thing)
            yield from self._step(step)
            for thing in things if self._world.poses else ():
                yield from self._visible(thing, since)
                yield from self._rivals(thing, since, isinstance(step, Face))
        yield from self._untold_bends()
        yield from self._described(meaning.target)
        yield from self._related(meaning.target)
        yield from self._told_apart(meaning.target)

    def _step(self, step: Step) -> Iterator[str]:
        if isinstance(step, Rotate):
            yield from self._turn(step)
        elif isinstance(step, Face):
            yield from self._face(step.thing)
        elif isinstance(step, Walk) and step.way == "along":
            road = self._world.road(step.things[0].identity)
            if road is None or min(road.distance(*self._world.path[i]) for i in self._next(12)) > road.width / 2:
                yield f"{step.things[0].identity} is not walked along"
        elif isinstance(step, Walk) and step.things:
            yield from self._walk(step)

    def _next(self, count: int) -> range:
        return range(self.at, min(self.at + count, len(self._world.path)))

    # What can be seen

    def _visible(self, thing: Thing, since: int) -> Iterator[str]:
        """Yield each thing that cannot be recognised while its step is walked, from a place `since` the one before."""
        until = self.at - 1 if self.at > since else since + FORESIGHT
        is_seen = thing.kind not in PLACES or thing.kind == "building_corner"
        for mark in self._world.landmarks(thing.identity) if is_seen else ():
            if not self._world.is_visible(mark, since - HINDSIGHT, until):
                yield f"{mark.identity} cannot be seen on the way to it"

    def _rivals(self, thing: Thing, since: int, is_faced: bool) -> Iterator[str]:
        """Yield each other thing of a name that is seen ahead, or as one turns, nearer than the one that is meant."""
        world, marks = self._world, self._world.landmarks(thing.identity)
        if thing.kind in PLACES or thing.which or thing.number or not marks:
            return
        view = Pose(*world.path[since], world.heading_after(since))
        own = math.hypot(*view.local(marks[0].x, marks[0].z))
        for other in world.marks:
            right, ahead = view.local(other.x, other.z)
            is_ahead = is_faced or (ahead > 1.0 and abs(right) <= ahead)
            is_nearer = is_ahead and math.hypot(right, ahead) < own - (0.0 if is_faced else 2.0)
            is_rival = is_nearer and other not in marks and _is_called(thing, other)
            if is_rival and world.is_visible(other, since, since if is_faced else max(self.at, since + FORESIGHT)):
                yield f"{other.identity} may be taken for {thing.identity}"

    def _before_the_walker(self, thing: Thing) -> Iterator[str]:
        world = self._world
        view = Pose(*world.path[self.at], world.heading_after(self.at))
        for mark in world.landmarks(thing.identity):
            right, ahead = view.local(mark.x, mark.z)
            if abs(math.degrees(math.atan2(right, ahead))) > AHEAD:
                yield f"{mark.identity} is not before one who is told of {thing.number}"

    # What a thing is called

    def _described(self, thing: Thing) -> Iterator[str]:
        if thing.kind in PLACES:
            yield from self._place(thing)
            return
        marks = self._world.landmarks(thing.identity)
        if not marks:
            yield f"{thing.kind} {thing.identity!r} does not exist"
        if thing.kind in COLOURED and not thing.colour and thing.identity not in self._named:
            yield f"{thing.identity} is not told by its colour"
        self._named.add(thing.identity)
        for mark in marks:
            label = mark.label
            if thing.kind != label.kind or thing.colour not in ("", label.colour) or thing.look not in ("", label.look):
                yield f"{thing.identity} is a {label}, not {thing.colour} {thing.look} {thing.kind}"
        if (thing.number == "two" and len(marks) != 2) or (thing.number == "several" and len(marks) < 2):
            yield f"{thing.identity} is {len(marks)}, not {thing.number}"
        if thing.which in ORDINALS and marks:
            place = self._count(thing, marks[0])
            if place != ORDINALS[thing.which]:
                yield f"{thing.identity} is number {place} of its kind, not the {thing.which}"
        elif thing.which == "next" and marks:
            own = self._passed(marks[0], self.at + 1)
            others = [
                self._passed(each, self.at + 1)
                for each in self._world.marks
                if each is not marks[0] and _is_called(replace(thing, which=""), each)
            ]
            if own is not None and any(place is not None and place < own for place in others):
                yield f"{thing.identity} is not the next of its kind"

    def _count(self, thing: Thing, mark: Landmark) -> int:
        """Return which of the fitting things along the way since the last turn a landmark is, from 1."""
        since = max((*self.turned, *self.faced, 0))
        own = self._passed(mark, since)
        if own is None:
            return 0
        others = (each for each in self._world.marks if each is not mark and _is_called(replace(thing, which=""), each))
        places = (self._passed(each, since) for each in others)
        return 1 + sum(place is not None and place <= own for place in places)

    def _passed(self, mark: Landmark, since: int) -> int | None:
        """Return the index where the path comes closest to a landmark that counts; None if it does not come near."""
        limit = WALKED_OVER if mark.label.kind == "zebra_crossing" else COUNTED_ASIDE
        return self._world.closest(mark.x, mark.z, since, limit)

    def _place(self, thing: Thing) -> Iterator[str]:
        world = self._world
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
        near = world.closest(junction.x, junction.z, self.at, junction.radius + AT)
        if near is None:
            yield f"the path does not come to {thing.identity}"
        elif not _is_kind(junction, thing.kind, world.heading_before(max(near - 2, 0))):
            yield f"{thing.identity} is a {junction.kind}, not a {thing.kind}"

    # Where it is

    def _related(self, thing: Thing) -> Iterator[str]:
        marks = self._world.landmarks(thing.identity)
        for where in thing.where:
            for landmark in where.things:
                yield from self._described(landmark)
            others = [mark for landmark in where.things for mark in self._world.landmarks(landmark.identity)]
            if marks and others and not self._holds(where, marks[0], others):
                yield f"{thing.identity} is not {where.relation} {where.things[0].identity}"
            elif marks and others and not self._is_nearest(where.things[0], marks[0], others):
                yield f"another is nearer to {thing.identity} than {where.things[0].identity}"

    def _told_apart(self, target: Thing) -> Iterator[str]:
        """Yield each other object in the street that what is said of the target fits as well."""
        own = self._world.landmarks(target.identity)
        for other in self._world.marks:
            if not own or other in own or not _is_called(target, other):
                continue
            if not any(self._stands_alone(where, other) for where in target.where):
                yield f"{target.identity} may be taken for {other.identity}"

    def _stands_alone(self, where: Where, other: Landmark) -> bool:
        """Return whether nothing near an object is called as what a relation names."""
        return not any(
            _distance(mark, other) <= TWIN_NEAR
            for mark in self._world.marks
            for thing in where.things
            if _is_called(thing, mark)
        )

    def _is_nearest(self, thing: Thing, mark: Landmark, others: list[Landmark]) -> bool:
        """Return whether no other thing that is called the same is nearer to a landmark."""
        own = min(_distance(mark, other) for other in others)
        rivals = (each for each in self._world.marks if each not in others and each != mark and _is_called(thing, each))
        return all(_distance(mark, rival) > own for rival in rivals)

    def _holds(self, where: Where, mark: Landmark, others: list[Landmark]) -> bool:
        if min(_distance(mark, other) for other in others) > (BY if others[0].label.kind == "building" else NEAR):
            return False
        path = self._world.path
        view = path[max(len(path) - 5, 0)]
        heading = math.degrees(math.atan2(mark.x - view[0], mark.z - view[1]))
        right, ahead = Pose(others[0].x, others[0].z, heading % 360.0).local(mark.x, mark.z)
        return {
            "left_of": right < 0.0, "right_of": right > 0.0, "in_front_of": ahead < 0.0, "behind": ahead > 0.0,
        }.get(where.relation, True)  # fmt: skip

    # What one does there

    def _last_choice(self) -> int:
        """Return the index of the place after which streets open that one could take: a thing may stand at one."""
        return self.at if self.at and self.at in self.turned else self.at - 2

    def _face(self, thing: Thing) -> Iterator[str]:
        world, (x, z) = self._world, self._middle((thing,))
        here = world.path[self.at]
        towards = math.degrees(math.atan2(x - here[0], z - here[1]))
        if abs(turn_between(world.heading_after(self.at), towards)) > FACED:
            yield f"the path does not lead on as one faces {thing.identity}"
        if thing.kind in PLACES:
            yield f"{thing.identity} is one of several places that one may face"
        self.faced.append(self.at)

    def _untold_bends(self) -> Iterator[str]:
        world = self._world
        for at, angle in world.bends.items():
            is_faced = any(abs(at - faced) <= PEAK for faced in self.faced)
            if abs(angle) > TOLD_BEND and at not in self.turned and not is_faced and not self._sees_goal(at):
                yield f"the path turns by {angle:.0f} degrees at its place {at}, which is not said"
        for at in range(len(world.path)):
            wide, is_told = (
                world.wide_bend(at),
                any(abs(at - each) <= TOLD_NEAR for each in (*self.turned, *self.faced)),
            )
            if wide is not None and abs(wide) > TOLD_BEND and not is_told and not self._sees_goal(at):
                yield f"the path turns by {wide:.0f} degrees in all around its place {at}, which is not said"
                return

    def _is_slight(self, index: int, degrees: float) -> bool:
        """Return whether the way as a whole turns slightly at a place; so does one that cannot be measured there."""
        if any(0 < abs(index - each) <= TOLD_NEAR for each in (*self.turned, *self.faced)):
            return True
        measured = (self._world.wide_bend(at) for at in range(index - PEAK, index + PEAK + 1))
        wide = [math.copysign(1.0, degrees) * each for each in measured if each is not None]
        own = self._world.wide_bend(index)
        return own is None or (math.copysign(1.0, degrees) * own >= SLIGHT_WIDE[0] and max(wide) <= SLIGHT_WIDE[1])

    def _sees_goal(self, at: int) -> bool:
        """Return whether the target is near a place of the path, and seen before the path turns there."""
        world = self._world
        if math.dist(world.path[at], world.goal) > AT_GOAL:
            return False
        targets = [mark for mark in world.marks if (mark.x, mark.z) == world.goal]
        return not world.poses or any(world.is_visible(mark, at - HINDSIGHT, at - 1) for mark in targets)

    def _turn(self, step: Rotate) -> Iterator[str]:
        degrees = DEGREES[step.direction]
        if step.thing is None:
            index = self._world.turn_near(self.at, degrees, TURN_REACH)
            if index is None:
                yield f"the path does not turn {step.direction} after its place {self.at}"
                return
            yield from self._turn_at(index, degrees)
            return
        near = self._nearest(step.thing, AT)
        reach = TURN_REACH + (3 if step.thing.kind in PLACES else 0)
        index = None if near is None else self._world.turn_near(near, degrees, reach)
        marks = self._world.landmarks(step.thing.identity)
        apart = [math.dist((mark.x, mark.z), self._world.path[index]) for mark in marks] if index is not None else []
        if near is None or index is None or (step.at == "at" and min(apart, default=0.0) > TURN_AT):
            yield f"the path does not turn {step.direction} {step.at} {step.thing.identity}"
            return
        if step.thing.kind in ("street", "alley"):
            yield from faults_of_street(self._world, self._last_choice(), step.thing, step.direction, index)
        elif step.thing.kind not in PLACES:
            yield from faults_of_turn_by(self._world, self.at, step, near, index)
        if step.at == "before" and any(is_beyond_turn(self._world, mark.x, mark.z, index) for mark in marks):
            yield f"{step.thing.identity} lies in the street after the turn"
        yield from self._turn_at(index, degrees)

    def _turn_at(self, index: int, degrees: float) -> Iterator[str]:
        if abs(degrees) < 90.0 and not self._is_slight(index, degrees):
            yield f"the path does not turn slightly at its place {index}, or only for a few paces"
        if index in self.turned:
            yield f"the path turns only once at its place {index}, not twice"
        self.turned.append(index)
        self.at = max(self.at, index)

    def _walk(self, walk: Walk) -> Iterator[str]:
        world, thing = self._world, walk.things[0]
        if walk.straight and walk.way in ("to", "towards", "until"):
            yield from self._straight_to(walk.things)
        if walk.way in ("until", "towards"):
            x, z = self._middle(walk.things)
            here = math.dist(world.path[self.at], (x, z))
            if min(math.dist(world.path[i], (x, z)) for i in self._next(30)) > here - 1.0 and here > 3.5:
                yield f"the path does not lead towards {thing.identity}"
            if walk.way == "towards":
                self.at = max(self.at, world.closest(x, z, self.at, BY) or 0)
            return
        near = self._nearest_of(walk.things, BY if walk.way in ("past", "beside") else AT)
        if near is None:
            yield f"the path does not come {walk.way} {thing.identity}"
            return
        least = ASIDE_ZEBRA if thing.kind == "zebra_crossing" else ASIDE
        marks = [mark for each in walk.things for mark in world.landmarks(each.identity)]
        rights = [world.side_of(mark.x, mark.z, near) for mark in marks]
        if walk.side and any(right * (1.0 if walk.side == "right" else -1.0) < least for right in rights):
            yield f"{thing.identity} is not on the {walk.side}"
        if walk.way == "between" and not self._is_amid(walk.things, near):
            yield f"the path does not lead between {thing.identity} and {walk.things[1].identity}"
        self.at = max(self.at, near)

    def _is_amid(self, things: tuple[Thing, ...], near: int) -> bool:
        """Return whether two things stand on both sides of the path, more beside each other than one behind another."""
        world = self._world
        before, after = world.path[max(near - 2, 0)], world.path[min(near + 2, len(world.path) - 1)]
        heading = math.degrees(math.atan2(after[0] - before[0], after[1] - before[1]))
        here = Pose(*world.path[near], heading)
        places = [here.local(mark.x, mark.z) for each in things for mark in world.landmarks(each.identity)]
        (right, along), (other, far) = min(places), max(places)
        return right < 0.0 < other and abs(right + other) <= 5.0 and abs(along - far) <= other - right

    def _straight_to(self, things: tuple[Thing, ...]) -> Iterator[str]:
        """Yield what is wrong with a walk straight to things: that they are not ahead, or the way there bends."""
        world, (x, z) = self._world, self._middle(things)
        here = world.path[self.at]
        towards = math.degrees(math.atan2(x - here[0], z - here[1]))
        is_turned = any(abs(self.at - said) <= TURN_REACH for said in (*self.turned, *self.faced))
        heading = world.heading_after(self.at) if is_turned else world.heading_before(self.at)
        if math.dist(here, (x, z)) > 3.0 and abs(turn_between(heading, towards)) > STRAIGHT:
            yield f"{things[0].identity} is not straight ahead"

    def _nearest(self, thing: Thing, limit: float) -> int | None:
        return self._nearest_of((thing,), limit)

    def _nearest_of(self, things: tuple[Thing, ...], limit: float) -> int | None:
        """Return the index where the path comes closest to things from where it is; None if it does not come near."""
        world = self._world
        if things[0].kind in ("street", "alley"):
            road = world.road(things[0].identity)
            far = range(self.at, len(world.path))
            entered = (i for i in far if road is not None and road.distance(*world.path[i]) <= road.width / 2)
            return next(entered, None)
        marks = [mark for thing in things for mark in world.landmarks(thing.identity)]
        if len(things) == 1 and marks and marks[0].label.kind != "building":
            near = [world.closest(mark.x, mark.z, max(self.at - 2, 0), limit) for mark in marks]
            return None if any(index is None for index in near) else max(index for index in near if index is not None)
        x, z = self._middle(things)
        junction = world.junction(things[0].identity)
        return world.closest(x, z, max(self.at - 2, 0), limit + (junction.radius if junction is not None else 0.0))

    def _middle(self, things: tuple[Thing, ...]) -> Place:
        world = self._world
        places: list[Place] = []
        for thing in things:
            junction, corner = world.junction(thing.identity), world.corner(thing.identity)
            if junction is not None:
                places.append((junction.x, junction.z))
            elif corner is not None:
                places.append((corner.x, corner.z))
            else:
                places += [(mark.x, mark.z) for mark in world.landmarks(thing.identity)]
        if not places:
            return world.path[self.at]
        return sum(x for x, _ in places) / len(places), sum(z for _, z in places) / len(places)


def _is_kind(junction: Junction, kind: str, heading: float) -> bool:
    """Return whether a junction may be called an intersection, and so on, by a walker who arrives with a heading."""
    if kind == "intersection":
        return len(junction.arms) >= 3
    if kind == "street_end":
        return junction.arm_towards(heading) is None
    if kind == "t_junction":
        return len(junction.arms) >= 3 and junction.arm_towards(heading) is None
    return junction.kind == "square" if kind == "square" else True


def _is_called(thing: Thing, mark: Landmark) -> bool:
    """Return whether the words of a name fit a landmark."""
    label = mark.label
    return thing.kind == label.kind and thing.colour in ("", label.colour) and thing.look in ("", label.look)


def _distance(one: Landmark, other: Landmark) -> float:
    return math.dist((one.x, one.z), (other.x, other.z))
