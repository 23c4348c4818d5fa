"""Plans what a navigation instruction says: from the ground truth's path and what is seen along it, in no language.

The plan is made of steps from landmark to landmark. Of every step it is reckoned where it leads one who takes it as
the follower does (agents/follower/navigation.py means the same by each), and the next is planned from there.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from random import Random

from lang.going import ALONG, BESIDE, DEGREES, NEAR, PAST
from lang.meaning import Face, Navigation, Step, Thing, Turn, Walk
from server.episodes.instruct.navigation_choice import fits, name_of
from server.episodes.instruct.navigation_legs import Place, bearing, legs_of, straying, turn_between
from server.episodes.instruct.navigation_target import describe
from server.episodes.instruct.sight import Landmark
from server.sim.catalogue import KINDS
from server.sim.geometry import Pose, wrap
from server.sim.rules import Collectible

BEYOND = {"past": PAST, **ALONG}
"""How far along from a landmark a step leads, in units."""

ASTRAY = 1.8
"""How far from the path a step may lead, in units."""

IN_VIEW, TURNED_TO = 50.0, 40.0
"""How far beside the course a landmark may be, and how far where one turns for it, in degrees."""

BENT = 25.0
"""A path whose next steps differ by more degrees from where it then goes on to does not turn yet."""

DOUBT = 2.0
"""What it costs to name a thing of which there is another that is only not seen on the way."""

GAP = (1.5, 7.0)
"""How far apart two things may be that one goes between, in units."""

FARTHEST = 30
"""How far one step may lead, in units."""

MOST_COUNTED, FEW_COUNTED = 14, 8
"""Paces that are counted at most, and those after which one looks for a landmark where there are more to go."""

LONGEST = 9
"""Steps that a plan may have."""


def plan_navigation(
    path: Sequence[Place],
    poses: Sequence[Pose],
    target: Collectible,
    street: Sequence[Collectible],
    marks: Sequence[Landmark],
    random: Random,
) -> Navigation | None:
    """What to say to one who is to walk a path; None where nothing is found that leads there.

    Args:
        path: the ground truth's distinct positions (x, z).
        poses: along it, of `sight.poses_along`.
        target: what is picked up in the end.
        street: all collectibles of the turn, the target among them.
        marks: what `sight.look` gave for the poses; it need be looked but once for many draws.
        random: draws what is said; another draw says it in another way.
    """
    thing = describe(target, street, marks, poses, random)
    if thing is None:
        return None
    steps = _Plan(path, poses, marks, (target.position.x, target.position.z), random).steps()
    return None if steps is None else Navigation(steps, thing)


@dataclass(frozen=True, slots=True)
class _Standing:
    """Where the steps so far have led.

    Attributes:
        pose: with the course that one is on as its heading.
        number: of the place in the path that is nearest.
        turned: whether one has just turned somewhere: who turns at once again did so at the wrong place.
    """

    pose: Pose
    number: int
    turned: bool = False


@dataclass(frozen=True, slots=True)
class _Option:
    """Steps that lead on; the less they cost the better."""

    cost: float
    steps: tuple[Step, ...]
    standing: _Standing


class _Plan:
    """Puts the steps together."""

    def __init__(
        self, path: Sequence[Place], poses: Sequence[Pose], marks: Sequence[Landmark], goal: Place, random: Random
    ) -> None:
        self._path, self._goal, self._random = path, goal, random
        self._marks = marks
        self._around = [mark for mark in marks if mark.glimpsed is not None and mark.glimpsed <= 0]
        # What is seen in looking round at the start alone is not seen by one who walks the path.
        self._first = {id(mark): next((n for n in mark.seen if n >= 0), len(poses)) for mark in marks}
        self._things = [mark for mark in marks if mark.label.kind not in (*KINDS, "intersection")]
        self._openings = [mark for mark in marks if mark.label.kind == "intersection"]
        self._corners = [leg.last for leg in legs_of(path)]
        self._target_seen = next((self._first[id(m)] for m in marks if (m.x, m.z) == goal), len(poses))
        self._departures = [0] * len(path)
        place = 0
        for number, pose in enumerate(poses):
            while place + 1 < len(path) and (pose.x, pose.z) != path[place]:
                place += 1
            self._departures[place] = number
        self._start = poses[0]

    def steps(self) -> tuple[Step, ...] | None:
        """All of them; None where they would be too many."""
        steps: list[Step] = []
        standing = _Standing(self._start, 0)
        while len(steps) <= LONGEST:
            last = self._last(standing)
            if last is not None and not (steps and self._may_say_more(standing)):
                return (*steps, *last)
            options = list(self._options(standing)) or [self._count(standing)]
            if last is not None:
                options = [o for o in options if len(o.steps) == 1 and not isinstance(o.steps[0], Turn)]
                if not options:
                    return (*steps, *last)
            chosen = min(options, key=lambda option: option.cost)
            steps += self._faced(chosen) if not steps else chosen.steps
            standing = chosen.standing
            if standing.number >= len(self._path) - 1 and self._last(standing) is None:
                return tuple(steps)
        return None

    def _may_say_more(self, standing: _Standing) -> bool:
        far = math.dist((standing.pose.x, standing.pose.z), self._goal)
        return far > 9.0 and self._random.random() < 0.3

    def _last(self, standing: _Standing) -> tuple[Step, ...] | None:
        """What is left to say where the target comes into view; None where it does not."""
        here = standing.pose.x, standing.pose.z
        soon = min(standing.number + 1, len(self._path) - 1)
        if self._target_seen > self._departures[soon]:
            return None
        if straying(self._path, standing.number, len(self._path) - 1, here, self._goal) > ASTRAY:
            return None
        off = turn_between(standing.pose.heading, bearing(here, self._goal))
        words = self._words(off)
        return None if words is None else tuple(Turn(word) for word in words)

    def _words(self, off: float) -> tuple[str, ...] | None:
        """The turn that brings what is so many degrees off the course into view; None where there is none."""
        if abs(off) <= IN_VIEW:
            return ()
        for word, degrees in DEGREES.items():
            if abs(turn_between(degrees, off)) <= TURNED_TO:
                return (word,)
        return None

    def _options(self, standing: _Standing) -> Iterator[_Option]:
        """What can be said next, by the landmarks that have been seen by now."""
        yield from self._turnings(standing)
        here = standing.pose.x, standing.pose.z
        named = []
        for mark in self._things:
            if self._first[id(mark)] > self._departures[standing.number]:
                continue
            distance = math.dist(here, (mark.x, mark.z))
            if not 2.0 <= distance <= FARTHEST:
                continue
            off = turn_between(standing.pose.heading, bearing(here, (mark.x, mark.z)))
            words = self._words(off)
            if words is None or (words and standing.turned) or (words == ("around",) and standing.number > 0):
                continue
            pose = standing.pose.turned(sum(DEGREES[word] for word in words))
            until = self._departures[min(standing.number + 12, len(self._path) - 1)]
            name = name_of(mark, self._marks, pose, until, self._random)
            if name is not None:
                turns = tuple(Turn(word) for word in words)
                doubt = 0.0 if name[1] else DOUBT
                if not words:
                    named.append((mark, name[0], doubt))
                yield from self._by(mark, name[0], turns, replace(standing, pose=pose), doubt)
        for (one, first, doubt), (other, second, more) in combinations(named, 2):
            if first != second and GAP[0] <= math.dist((one.x, one.z), (other.x, other.z)) <= GAP[1]:
                end = self._passing(standing.pose, (one.x + other.x) / 2, (one.z + other.z) / 2, 0.3)
                yield from self._option(standing, (), Walk("between", (first, second)), end, doubt + more + 0.8)

    def _turnings(self, standing: _Standing) -> Iterator[_Option]:
        """Turns into the next street on either side."""
        pose = standing.pose
        for side, degrees in (("left", -90.0), ("right", 90.0)):
            ahead = []
            for mark in self._openings:
                right, along = pose.local(mark.x, mark.z)
                if mark.label.look == side and along > -1.0 and abs(right) < ASTRAY:
                    ahead.append((along, mark))
            if not ahead:
                continue
            along, mark = min(ahead, key=lambda item: item[0])
            end = pose.ahead(along)
            onward = self._onward(self._nearest(end, standing.number))
            if mark.seen[0] > self._departures[standing.number] or along < 1.5 or onward is None:
                continue
            at_once = self._onward(self._nearest(end, standing.number), 2)
            inexact = abs(turn_between(pose.heading + degrees, onward))
            if inexact < 40.0 and at_once is not None and abs(turn_between(onward, at_once)) < 2.0 * BENT:
                thing = Thing(self._random.choice(("intersection", "corner")))
                yield from self._option(
                    standing, (), Turn(side, "at", thing), end.turned(degrees), inexact / 20.0 - 1.0
                )

    @staticmethod
    def _passing(pose: Pose, x: float, z: float, beyond: float) -> Pose:
        """Where one is who has gone by a place, from a pose."""
        right, ahead = pose.local(x, z)
        aside = right - min(max(right, -BESIDE), BESIDE)
        course = pose.turned(math.degrees(math.atan2(aside, max(ahead, 0.5))))
        return course.ahead(course.local(x, z)[1] + beyond)

    def _by(
        self, mark: Landmark, name: Thing, turns: tuple[Step, ...], standing: _Standing, doubt: float
    ) -> Iterator[_Option]:
        """What can be said of one landmark, after the turns."""
        pose = standing.pose
        right, _ = pose.local(mark.x, mark.z)
        for word, beyond in BEYOND.items():
            end = self._passing(pose, mark.x, mark.z, beyond)
            if math.dist((pose.x, pose.z), (end.x, end.z)) < 1.5 or pose.local(end.x, end.z)[1] < 0.0:
                continue
            if word == "past":
                side = "" if self._random.random() < 0.6 or abs(right) < 0.6 else "right" if right > 0.0 else "left"
                yield from self._option(standing, turns, Walk("past", (name,), side), end, doubt)
                continue
            number = self._nearest(end, standing.number)
            onward = self._onward(number)
            at_once = self._onward(number, 2)
            if onward is None or at_once is None or abs(turn_between(onward, at_once)) > BENT:
                continue
            rotation = turn_between(end.heading, onward)
            direction = min(DEGREES, key=lambda w: abs(turn_between(DEGREES[w], rotation)))
            inexact = abs(turn_between(DEGREES[direction], rotation))
            if abs(rotation) > 35.0 and direction != "around":
                end = end.turned(DEGREES[direction])
                yield from self._option(
                    standing,
                    turns,
                    Turn(direction, word, name),
                    end,
                    inexact / 20.0 + doubt + (-1.0 if abs(rotation) > 50.0 else 0.7),
                )
        straight = Pose(pose.x, pose.z, bearing((pose.x, pose.z), (mark.x, mark.z)))
        distance = math.dist((pose.x, pose.z), (mark.x, mark.z))
        for way, near in NEAR.items():
            if distance - near > 2.0:
                yield from self._option(
                    standing, turns, Walk(way, (name,)), straight.ahead(distance - near), 0.6 + doubt
                )

    def _option(
        self, standing: _Standing, turns: tuple[Step, ...], step: Step, end: Pose, cost: float
    ) -> Iterator[_Option]:
        """The option to take these steps, where they lead on along the path."""
        number = self._nearest(end, standing.number)
        if number < standing.number + 2 and number < len(self._path) - 1:
            return
        here = standing.pose.x, standing.pose.z
        off = math.dist((end.x, end.z), self._path[number])
        strayed = straying(self._path, standing.number, number, here, (end.x, end.z))
        if off > ASTRAY or strayed > ASTRAY:
            return
        gain = min(number - standing.number, 14)
        onward = self._onward(number)
        wrong = 0.0 if onward is None else max(abs(turn_between(end.heading, onward)) - 15.0, 0.0) / 25.0
        total = cost + 0.8 * off + 0.5 * strayed - 0.25 * gain + 1.2 * len(turns) + wrong + 1.5 * self._random.random()
        yield _Option(total, (*turns, step), _Standing(end, number, isinstance(step, Turn)))

    def _count(self, standing: _Standing) -> _Option:
        """Steps counted to the next corner, where there is no landmark."""
        here = standing.pose.x, standing.pose.z
        corner = next((c for c in self._corners if c > standing.number + 1), len(self._path) - 1)
        rotation = turn_between(standing.pose.heading, bearing(here, self._path[corner]))
        words: tuple[str, ...] = ()
        while abs(rotation) > 18.0:
            word = min(DEGREES, key=lambda w: abs(turn_between(DEGREES[w], rotation)))
            words, rotation = (*words, word), turn_between(DEGREES[word], rotation)
        count = max(round(math.dist(here, self._path[corner])), 1)
        if count > MOST_COUNTED:
            count = FEW_COUNTED
        pose = standing.pose.turned(sum(DEGREES[word] for word in words)).ahead(count)
        number = corner if count != FEW_COUNTED else self._nearest(pose, standing.number + 1)
        return _Option(0.0, (*(Turn(word) for word in words), Walk("ahead", count=count)), _Standing(pose, number))

    def _faced(self, option: _Option) -> tuple[Step, ...]:
        """An option's steps, where the first turn may be said as one to a thing."""
        if len(option.steps) < 2 or self._random.random() > 0.5:
            return option.steps
        after = option.steps[-1]
        thing = (
            after.thing
            if isinstance(after, Turn)
            else after.things[0]
            if isinstance(after, Walk) and after.things
            else None
        )
        if thing is None or sum(fits(thing, mark) for mark in self._around) != 1:
            return option.steps
        return (Face(thing), after)

    def _nearest(self, pose: Pose, since: int) -> int:
        """The number of the place in the path that is nearest to a pose, of those from `since` on."""
        until = min(since + FARTHEST, len(self._path))
        return min(range(since, until), key=lambda i: math.dist(self._path[i], (pose.x, pose.z)))

    def _onward(self, number: int, far: int = 5) -> float | None:
        """Where the path goes on to from a place in it, over the next so many; None at its end."""
        ahead = min(number + far, len(self._path) - 1)
        if ahead <= number:
            return None if self._path[number] == self._goal else bearing(self._path[number], self._goal)
        return wrap(bearing(self._path[number], self._path[ahead]))
