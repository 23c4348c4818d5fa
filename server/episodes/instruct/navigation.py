"""Plans what a navigation instruction says: from the ground truth's path and what is seen along it, in no language."""

import math
from collections.abc import Sequence
from dataclasses import replace
from random import Random

from lang.meaning import Face, Navigation, Step, Thing, Turn, Walk
from server.episodes.instruct.navigation_choice import Named, fits, nameable
from server.episodes.instruct.navigation_legs import Leg, bearing, legs_of, turn_between
from server.episodes.instruct.navigation_target import describe
from server.episodes.instruct.sight import Landmark, look, poses_along
from server.sim.cameras import Camera
from server.sim.geometry import Pose
from server.sim.rules import Action, Collectible
from server.sim.section import Section

ATS = (("at", 0.0), ("before", -1.5), ("after", 1.5))
"""Where a turn is taken from a landmark, in units along the leg: what the follower takes the words for."""

ASTRAY = 1.4
"""How far from where it was taken a turn may come to lie, in units along the leg."""

ASIDE = 4.0
"""How far beside a leg a landmark may stand, in units."""

INEXACT = 18.0
"""Degrees by which a turn may differ from its word without a landmark that shows the way on."""

ROTATIONS: dict[int, tuple[str, ...]] = {
    0: (),
    30: ("slightly right",),
    60: ("right", "slightly left"),
    90: ("right",),
    120: ("right", "slightly right"),
    150: ("around", "slightly left"),
    180: ("around",),
    -30: ("slightly left",),
    -60: ("left", "slightly right"),
    -90: ("left",),
    -120: ("left", "slightly left"),
    -150: ("around", "slightly right"),
}
NOMINAL = {"left": -90.0, "right": 90.0, "around": 180.0, "slightly left": -30.0, "slightly right": 30.0}


def plan_navigation(
    path: Sequence[tuple[float, float]],
    actions: Sequence[Action],
    start: Pose,
    target: Collectible,
    street: Sequence[Collectible],
    section: Section,
    camera: Camera,
    random: Random,
) -> Navigation | None:
    """What to say to one who is to walk a path; None where nothing can be said that leads there.

    Args:
        path: the ground truth's distinct positions (x, z).
        actions: the ground truth's, the pick-up may be included.
        start: the pose that it begins from.
        target: what is picked up in the end.
        street: all collectibles of the turn, the target among them.
        section: where it is.
        camera: of the section's scene.
        random: draws what is said; another draw says it in another way.
    """
    poses = poses_along(start, path, actions)
    return plan_from_sight(path, poses, target, street, look(poses, street, section, camera), random)


def plan_from_sight(
    path: Sequence[tuple[float, float]],
    poses: Sequence[Pose],
    target: Collectible,
    street: Sequence[Collectible],
    marks: Sequence[Landmark],
    random: Random,
) -> Navigation | None:
    """As `plan_navigation`, from what `sight.look` gave for the poses: it need be looked but once."""
    legs = legs_of(path)
    thing = describe(target, street, marks, poses, random)
    if thing is None:
        return None
    goal = target.position.x, target.position.z
    plan = _Plan(path, poses, marks, legs, goal, random)
    return Navigation(plan.steps(), thing)


_Words = tuple[tuple[Step, ...], float]
"""Steps, and the degrees that are left to turn after them."""


class _Plan:
    """Puts the steps together, leg by leg."""

    def __init__(
        self,
        path: Sequence[tuple[float, float]],
        poses: Sequence[Pose],
        marks: Sequence[Landmark],
        legs: Sequence[Leg],
        goal: tuple[float, float],
        random: Random,
    ) -> None:
        self._around = [mark for mark in marks if mark.seen[0] <= 0]
        onward = (replace(mark, seen=tuple(n for n in mark.seen if n >= 0)) for mark in marks)
        self._marks = [mark for mark in onward if mark.seen]
        self._legs, self._goal, self._random = legs, goal, random
        self._end = path[-1]
        self._target_seen = next((m.seen[0] for m in self._marks if (m.x, m.z) == goal), len(poses))
        arrivals: dict[tuple[float, float], int] = {}
        departures: dict[tuple[float, float], int] = {}
        for number, pose in enumerate(poses):
            arrivals.setdefault((pose.x, pose.z), number)
            departures[pose.x, pose.z] = number
        self._arrivals = [arrivals[place] for place in path]
        self._departures = [departures[place] for place in path]
        self._heading = poses[0].heading

    def steps(self) -> tuple[Step, ...]:
        """All of them."""
        steps: list[Step] = []
        if not self._legs:
            rotation = turn_between(self._heading, bearing(self._end, self._goal))
            return self._rotate(rotation, "", None)[0][0] if abs(rotation) > 30.0 else ()
        exact, short = self._begin()
        for number, leg in enumerate(self._legs):
            walks, reached = self._walks(leg, short[1])
            # A turn that is only nearly right needs a landmark to show the way on.
            rough = bool(walks) and (abs(short[1]) <= INEXACT or self._random.random() < 0.6)
            steps += [*(short[0] if rough else exact[0]), *walks]
            if number < len(self._legs) - 1:
                exact, short = self._turn(leg, self._legs[number + 1], reached)
        return tuple(steps)

    def _begin(self) -> tuple[_Words, _Words]:
        """What faces the first leg, exactly and in short, each with the degrees that it is off."""
        first = self._legs[0]
        rotation = turn_between(self._heading, first.heading)
        if abs(rotation) > 25.0 and self._random.random() < 0.35:
            named = nameable(self._around, first, 0, self._departures[first.first], self._random)
            facing = [n for n in named if abs(_off(n)) < 12.0 and n.along > 2.0 and self._is_alone(n.thing)]
            if facing:
                face: _Words = ((Face(self._random.choice(facing).thing),), 0.0)
                return face, face
        return self._rotate(rotation, "", None)

    def _rotate(self, rotation: float, at: str, thing: Thing | None) -> tuple[_Words, _Words]:
        nearest = min(ROTATIONS, key=lambda degrees: abs(turn_between(degrees, rotation)))
        words = ROTATIONS[nearest]
        turns = tuple(Turn(word, "" if i else at, None if i else thing) for i, word in enumerate(words))
        exact: _Words = (turns, turn_between(rotation, nearest))
        if len(words) < 2:
            return exact, exact
        return exact, (turns[:1], turn_between(rotation, NOMINAL[words[0]]))

    def _is_alone(self, thing: Thing) -> bool:
        """Whether only one thing of that name is seen by one who looks round at the start."""
        return sum(fits(thing, mark) for mark in self._around) == 1

    def _walks(self, leg: Leg, off: float) -> tuple[tuple[Walk, ...], float]:
        """Things to walk by on the leg, and how far these lead along it.

        Args:
            leg: the leg.
            off: degrees from the way that one faces who begins it to the way it goes.
        """
        walks: list[Walk] = []
        reached = 0.0
        is_open = leg is self._legs[-1] and self._target_seen > self._departures[leg.first] + 2
        while leg.length - reached > (9.0 if walks else 3.0 if abs(off) > INEXACT else 5.0):
            may_stop = abs(off) <= INEXACT and not is_open and not walks and leg.length < 12.0
            if may_stop and self._random.random() < 0.25:
                break
            option = self._walk(leg, reached, off if not walks else 0.0)
            if option is None:
                break
            walks.append(option[0])
            reached = max(option[1], reached + 0.5)
        return tuple(walks), reached

    def _walk(self, leg: Leg, reached: float, off: float) -> tuple[Walk, float] | None:
        """One thing to walk by from so far along the leg, and how far along it leads."""
        start = self._path_number(leg, reached)
        since = self._departures[start]
        until = self._arrivals[min(start + 2, leg.last)] if abs(off) <= INEXACT else since
        options: list[tuple[float, Walk, float]] = []
        for named in nameable(self._marks, leg, since, until, self._random, start=reached, off=off):
            along = named.along - reached
            if abs(named.right) > 3.0 or along < 2.5 or abs(math.degrees(math.atan2(named.right, along)) - off) > 50.0:
                continue
            side = "" if self._random.random() < 0.5 or abs(named.right) < 0.6 else _side(named)
            score = abs(named.right) + 0.1 * abs(along - 8.0) + 1.5 * self._random.random()
            if named.along < leg.length - 2.0:
                options.append((score, Walk("past", (named.thing,), side), named.along + 0.8))
            if along > 4.0 and abs(named.right) < 1.5 and named.along - 2.5 < leg.length:
                options.append((score + 0.5, Walk("towards", (named.thing,)), named.along - 3.0))
        if not options:
            return None
        _, walk, reached = min(options, key=lambda option: option[0])
        return walk, reached

    def _turn(self, leg: Leg, following: Leg, reached: float) -> tuple[_Words, _Words]:
        """What turns into the next leg, exactly and in short, each with the degrees that it is off."""
        rotation = turn_between(leg.heading, following.heading)
        seen_by = self._path_number(leg, max(leg.length - 2.5, reached))
        here = self._departures[self._path_number(leg, reached)]
        options: list[tuple[float, str, Thing]] = []
        for named in nameable(self._marks, leg, here, self._arrivals[seen_by], self._random, start=reached):
            for at, offset in ATS:
                astray = abs(named.along + offset - leg.length)
                if astray < ASTRAY and abs(named.right) < ASIDE and named.along > reached - 0.5:
                    score = 1.5 * astray + 0.3 * abs(named.right) + 1.5 * self._random.random()
                    options.append((score, at, named.thing))
        if options:
            _, at, thing = min(options, key=lambda option: option[0])
            return self._rotate(rotation, at, thing)
        count = round(leg.length - max(reached, 0.0))
        before = (Walk("ahead", count=count),) if count > 0 else ()
        exact, short = self._rotate(rotation, "", None)
        return (before + exact[0], exact[1]), (before + short[0], short[1])

    def _path_number(self, leg: Leg, along: float) -> int:
        """The number of the place in the path that is so far along a leg."""
        share = min(max(along / leg.length, 0.0), 1.0)
        return leg.first + round(share * (leg.last - leg.first))


def _off(named: Named) -> float:
    """How far beside the leg's direction it is seen from the leg's start, in degrees."""
    return math.degrees(math.atan2(named.right, named.along))


def _side(named: Named) -> str:
    return "right" if named.right > 0.0 else "left"
