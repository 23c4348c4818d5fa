"""Planning of navigation instructions: steps in no language, from the ground truth's path and the landmarks along it.

A plan is a sequence of steps from landmark to landmark. Each step's end is predicted with the follower's semantics
(agents/follower/navigation.py), and the next step is planned from there.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from random import Random

from lang.meaning import Face, Navigation, Rotate, Step, Thing, Walk
from lang.street import ALONG, BESIDE, DEGREES, NEAR, PAST
from server.dataset.instructions.navigation_choice import fits, name_of
from server.dataset.instructions.navigation_legs import Place, bearing, legs_of, max_deviation, turn_between
from server.dataset.instructions.navigation_target import describe
from server.dataset.instructions.sight import Landmark
from server.sim.catalogue import KINDS
from server.sim.geometry import Pose, wrap
from server.sim.rules import Collectible

BEYOND = {"past": PAST, **ALONG}
"""Distance along the course from a landmark to where a step ends, in units."""

MAX_DEVIATION = 1.8
"""Maximum distance of a step from the path, in units."""

IN_VIEW, IN_VIEW_AFTER_TURN = 50.0, 40.0
"""Maximum angle between the course and a landmark, and between a turn and the landmark it is for, in degrees."""

MAX_BEND = 25.0
"""If the path's next steps differ by more degrees from its later direction, the path has not turned yet."""

AMBIGUITY_COST = 2.0
"""Cost of naming a landmark that could be confused with one not visible from the path."""

GAP_WIDTH = (1.5, 7.0)
"""Range of the distance between two landmarks to walk between, in units."""

MAX_STEP_LENGTH = 30
"""Maximum distance that one step leads, in units."""

MAX_COUNT, SHORT_COUNT = 14, 8
"""Maximum count of paces, and the count used instead if more are needed, after which a landmark is sought."""

MAX_STEPS = 9
"""Maximum number of steps of a plan."""


def plan_navigation(
    path: Sequence[Place],
    poses: Sequence[Pose],
    target: Collectible,
    street: Sequence[Collectible],
    marks: Sequence[Landmark],
    random: Random,
) -> Navigation | None:
    """Return the meaning of an instruction to walk a path, or None if no plan leads there.

    Args:
        path: distinct positions (x, z) of the ground truth.
        poses: along the path, from `sight.poses_along`.
        target: the object to pick up at the end.
        street: all collectibles of the turn, including the target.
        marks: result of `sight.find_landmarks` for the poses; can be reused for many draws.
        random: draws the wording; another draw gives another plan.
    """
    thing = describe(target, street, marks, poses, random)
    if thing is None:
        return None
    steps = _Planner(path, poses, marks, (target.position.x, target.position.z), random).steps()
    return None if steps is None else Navigation(steps, thing)


@dataclass(frozen=True, slots=True)
class _Waypoint:
    """Where the steps so far lead.

    Attributes:
        pose: position, with the course as heading.
        number: index of the nearest place in the path.
        turned: whether the last step was a turn: a second one at once means that the first was misplaced.
    """

    pose: Pose
    number: int
    turned: bool = False


@dataclass(frozen=True, slots=True)
class _Option:
    """A candidate continuation; lower cost is better."""

    cost: float
    steps: tuple[Step, ...]
    waypoint: _Waypoint


class _Planner:
    """Builds the steps of a plan."""

    def __init__(
        self, path: Sequence[Place], poses: Sequence[Pose], marks: Sequence[Landmark], goal: Place, random: Random
    ) -> None:
        self._path, self._goal, self._random = path, goal, random
        self._marks = marks
        self._around = [mark for mark in marks if mark.glimpsed is not None and mark.glimpsed <= 0]
        # Index -1, a look around at the start, does not count: those landmarks are not seen while walking.
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
        """Return all steps, or None if there are too many."""
        steps: list[Step] = []
        waypoint = _Waypoint(self._start, 0)
        while len(steps) <= MAX_STEPS:
            last = self._final_steps(waypoint)
            if last is not None and not (steps and self._may_say_more(waypoint)):
                return (*steps, *last)
            options = list(self._options(waypoint)) or [self._counted_steps(waypoint)]
            if last is not None:
                options = [o for o in options if len(o.steps) == 1 and not isinstance(o.steps[0], Rotate)]
                if not options:
                    return (*steps, *last)
            chosen = min(options, key=lambda option: option.cost)
            steps += self._with_facing(chosen) if not steps else chosen.steps
            waypoint = chosen.waypoint
            if waypoint.number >= len(self._path) - 1 and self._final_steps(waypoint) is None:
                return tuple(steps)
        return None

    def _may_say_more(self, waypoint: _Waypoint) -> bool:
        far = math.dist((waypoint.pose.x, waypoint.pose.z), self._goal)
        return far > 9.0 and self._random.random() < 0.3

    def _final_steps(self, waypoint: _Waypoint) -> tuple[Step, ...] | None:
        """Return the remaining steps if the target comes into view, else None."""
        here = waypoint.pose.x, waypoint.pose.z
        soon = min(waypoint.number + 1, len(self._path) - 1)
        if self._target_seen > self._departures[soon]:
            return None
        if max_deviation(self._path, waypoint.number, len(self._path) - 1, here, self._goal) > MAX_DEVIATION:
            return None
        off = turn_between(waypoint.pose.heading, bearing(here, self._goal))
        words = self._turn_towards(off)
        return None if words is None else tuple(Rotate(word) for word in words)

    def _turn_towards(self, off: float) -> tuple[str, ...] | None:
        """Return the turn that brings a landmark at this angle to the course into view, or None if there is none."""
        if abs(off) <= IN_VIEW:
            return ()
        for word, degrees in DEGREES.items():
            if abs(turn_between(degrees, off)) <= IN_VIEW_AFTER_TURN:
                return (word,)
        return None

    def _options(self, waypoint: _Waypoint) -> Iterator[_Option]:
        """Yield possible continuations by the landmarks seen so far."""
        yield from self._side_streets(waypoint)
        here = waypoint.pose.x, waypoint.pose.z
        named = []
        for mark in self._things:
            if self._first[id(mark)] > self._departures[waypoint.number]:
                continue
            distance = math.dist(here, (mark.x, mark.z))
            if not 2.0 <= distance <= MAX_STEP_LENGTH:
                continue
            off = turn_between(waypoint.pose.heading, bearing(here, (mark.x, mark.z)))
            words = self._turn_towards(off)
            if words is None or (words and waypoint.turned) or (words == ("around",) and waypoint.number > 0):
                continue
            pose = waypoint.pose.turned(sum(DEGREES[word] for word in words))
            until = self._departures[min(waypoint.number + 12, len(self._path) - 1)]
            name = name_of(mark, self._marks, pose, until, self._random)
            if name is not None:
                turns = tuple(Rotate(word) for word in words)
                doubt = 0.0 if name[1] else AMBIGUITY_COST
                if not words:
                    named.append((mark, name[0], doubt))
                yield from self._landmark_options(mark, name[0], turns, replace(waypoint, pose=pose), doubt)
        for (one, first, doubt), (other, second, more) in combinations(named, 2):
            if first != second and GAP_WIDTH[0] <= math.dist((one.x, one.z), (other.x, other.z)) <= GAP_WIDTH[1]:
                end = self._pose_after_passing(waypoint.pose, (one.x + other.x) / 2, (one.z + other.z) / 2, 0.3)
                yield from self._option(waypoint, (), Walk("between", (first, second)), end, doubt + more + 0.8)

    def _side_streets(self, waypoint: _Waypoint) -> Iterator[_Option]:
        """Yield turns into the next street on either side."""
        pose = waypoint.pose
        for side, degrees in (("left", -90.0), ("right", 90.0)):
            ahead = []
            for mark in self._openings:
                right, along = pose.local(mark.x, mark.z)
                if mark.label.look == side and along > -1.0 and abs(right) < MAX_DEVIATION:
                    ahead.append((along, mark))
            if not ahead:
                continue
            along, mark = min(ahead, key=lambda item: item[0])
            end = pose.ahead(along)
            onward = self._onward_heading(self._nearest(end, waypoint.number))
            if mark.seen[0] > self._departures[waypoint.number] or along < 1.5 or onward is None:
                continue
            at_once = self._onward_heading(self._nearest(end, waypoint.number), 2)
            inexact = abs(turn_between(pose.heading + degrees, onward))
            if inexact < 40.0 and at_once is not None and abs(turn_between(onward, at_once)) < 2.0 * MAX_BEND:
                thing = Thing(self._random.choice(("intersection", "corner")))
                yield from self._option(
                    waypoint, (), Rotate(side, "at", thing), end.turned(degrees), inexact / 20.0 - 1.0
                )

    @staticmethod
    def _pose_after_passing(pose: Pose, x: float, z: float, beyond: float) -> Pose:
        """Return the pose after passing a place."""
        right, ahead = pose.local(x, z)
        aside = right - min(max(right, -BESIDE), BESIDE)
        course = pose.turned(math.degrees(math.atan2(aside, max(ahead, 0.5))))
        return course.ahead(course.local(x, z)[1] + beyond)

    def _landmark_options(
        self, mark: Landmark, name: Thing, turns: tuple[Step, ...], waypoint: _Waypoint, doubt: float
    ) -> Iterator[_Option]:
        """Yield continuations by one landmark, after the given turns."""
        pose = waypoint.pose
        right, _ = pose.local(mark.x, mark.z)
        for word, beyond in BEYOND.items():
            end = self._pose_after_passing(pose, mark.x, mark.z, beyond)
            if math.dist((pose.x, pose.z), (end.x, end.z)) < 1.5 or pose.local(end.x, end.z)[1] < 0.0:
                continue
            if word == "past":
                side = "" if self._random.random() < 0.6 or abs(right) < 0.6 else "right" if right > 0.0 else "left"
                yield from self._option(waypoint, turns, Walk("past", (name,), side), end, doubt)
                continue
            number = self._nearest(end, waypoint.number)
            onward = self._onward_heading(number)
            at_once = self._onward_heading(number, 2)
            if onward is None or at_once is None or abs(turn_between(onward, at_once)) > MAX_BEND:
                continue
            rotation = turn_between(end.heading, onward)
            direction = min(DEGREES, key=lambda w: abs(turn_between(DEGREES[w], rotation)))
            inexact = abs(turn_between(DEGREES[direction], rotation))
            if abs(rotation) > 35.0 and direction != "around":
                end = end.turned(DEGREES[direction])
                yield from self._option(
                    waypoint,
                    turns,
                    Rotate(direction, word, name),
                    end,
                    inexact / 20.0 + doubt + (-1.0 if abs(rotation) > 50.0 else 0.7),
                )
        straight = Pose(pose.x, pose.z, bearing((pose.x, pose.z), (mark.x, mark.z)))
        distance = math.dist((pose.x, pose.z), (mark.x, mark.z))
        for way, near in NEAR.items():
            if distance - near > 2.0:
                yield from self._option(
                    waypoint, turns, Walk(way, (name,)), straight.ahead(distance - near), 0.6 + doubt
                )

    def _option(
        self, waypoint: _Waypoint, turns: tuple[Step, ...], step: Step, end: Pose, cost: float
    ) -> Iterator[_Option]:
        """Yield the continuation by these steps if they advance along the path."""
        number = self._nearest(end, waypoint.number)
        if number < waypoint.number + 2 and number < len(self._path) - 1:
            return
        here = waypoint.pose.x, waypoint.pose.z
        off = math.dist((end.x, end.z), self._path[number])
        strayed = max_deviation(self._path, waypoint.number, number, here, (end.x, end.z))
        if off > MAX_DEVIATION or strayed > MAX_DEVIATION:
            return
        gain = min(number - waypoint.number, 14)
        onward = self._onward_heading(number)
        wrong = 0.0 if onward is None else max(abs(turn_between(end.heading, onward)) - 15.0, 0.0) / 25.0
        total = cost + 0.8 * off + 0.5 * strayed - 0.25 * gain + 1.2 * len(turns) + wrong + 1.5 * self._random.random()
        yield _Option(total, (*turns, step), _Waypoint(end, number, isinstance(step, Rotate)))

    def _counted_steps(self, waypoint: _Waypoint) -> _Option:
        """Return a continuation by counted paces to the next corner, for use without a landmark."""
        here = waypoint.pose.x, waypoint.pose.z
        corner = next((c for c in self._corners if c > waypoint.number + 1), len(self._path) - 1)
        rotation = turn_between(waypoint.pose.heading, bearing(here, self._path[corner]))
        words: tuple[str, ...] = ()
        while abs(rotation) > 18.0:
            word = min(DEGREES, key=lambda w: abs(turn_between(DEGREES[w], rotation)))
            words, rotation = (*words, word), turn_between(DEGREES[word], rotation)
        count = max(round(math.dist(here, self._path[corner])), 1)
        if count > MAX_COUNT:
            count = SHORT_COUNT
        pose = waypoint.pose.turned(sum(DEGREES[word] for word in words)).ahead(count)
        number = corner if count != SHORT_COUNT else self._nearest(pose, waypoint.number + 1)
        return _Option(0.0, (*(Rotate(word) for word in words), Walk("ahead", count=count)), _Waypoint(pose, number))

    def _with_facing(self, option: _Option) -> tuple[Step, ...]:
        """Return the option's steps, with the first turn sometimes expressed as facing a landmark."""
        if len(option.steps) < 2 or self._random.random() > 0.5:
            return option.steps
        after = option.steps[-1]
        thing = (
            after.thing
            if isinstance(after, Rotate)
            else after.things[0]
            if isinstance(after, Walk) and after.things
            else None
        )
        if thing is None or sum(fits(thing, mark) for mark in self._around) != 1:
            return option.steps
        return (Face(thing), after)

    def _nearest(self, pose: Pose, since: int) -> int:
        """Return the index of the place in the path nearest to a pose, from `since` on."""
        until = min(since + MAX_STEP_LENGTH, len(self._path))
        return min(range(since, until), key=lambda i: math.dist(self._path[i], (pose.x, pose.z)))

    def _onward_heading(self, number: int, far: int = 5) -> float | None:
        """Return the direction of the path from a place over its next `far` places; None at its end."""
        ahead = min(number + far, len(self._path) - 1)
        if ahead <= number:
            return None if self._path[number] == self._goal else bearing(self._path[number], self._goal)
        return wrap(bearing(self._path[number], self._path[ahead]))
