"""The ground-truth path as the planner uses it: positions, directions, and the landmarks seen so far."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from random import Random

from arramon_client.world import bearing, turn_between
from arramon_dataset.instructions.visible_landmarks import Landmark
from arramon_dataset.path_tolerances import (
    PLANNED_AROUND,
    PLANNED_DEVIATION,
    PLANNED_FAR,
    PLANNED_IN_VIEW,
    PLANNED_SLIGHT,
    PLANNED_STRAIGHT,
)
from arramon_dataset.paths import PathGeometry, Place, max_deviation
from arramon_dataset.plans.graph import StreetGraph
from arramon_lang.coreference import things_of
from arramon_lang.meaning import Rotate, Step, Walk
from arramon_lang.street_words import DEGREES, PASSED_WITHIN
from arramon_lang.writing.voice import MANNERS, Manner
from arramon_server.sim.geometry import Pose, wrap

SNAP = 40.0
"""Maximum angle between a step's course and the path at which the course is replaced by the path's, in degrees."""

GROUP_PREFERENCE = 0.1
"""Probability that a plan prefers groups of landmarks ("the cones") where there are any."""

MAX_STEP_LENGTH = 30
"""Maximum length of one step of a plan, in units."""


@dataclass(frozen=True, slots=True)
class Waypoint:
    """The predicted state after some steps.

    Attributes:
        pose: position, with the course as heading.
        number: index of the nearest place in the path.
        turned: whether the last step was a turn; the planner never puts one turn directly after another.
        about: identity of the thing of the last step; "" if it had none.
    """

    pose: Pose
    number: int
    turned: bool = False
    about: str = ""


@dataclass(frozen=True, slots=True)
class StepOption:
    """A candidate continuation; lower cost is better."""

    cost: float
    steps: tuple[Step, ...]
    waypoint: Waypoint


class DescribedRoute:
    """A path with the landmarks seen along it.

    Args:
        path: distinct positions (x, z) of the ground truth.
        poses: along the path, from `visible_landmarks.poses_along`.
        landmarks: from `visible_landmarks.find_landmarks`.
        goal: (x, z) of the target.
        graph: of the section's streets, or None.
        random: draws all choices.
        manner: how much to say.
        is_first: whether it is the episode's first turn, at whose start the walker's heading is known.

    Attributes:
        geometry: directions of the path.
        target: the target's label; None if it is not among the landmarks.
        has_twin: whether another object looks like the target.
        prefers_groups: whether the plan prefers groups of landmarks.
    """

    def __init__(
        self,
        path: Sequence[Place],
        poses: Sequence[Pose],
        landmarks: Sequence[Landmark],
        goal: Place,
        graph: StreetGraph | None,
        random: Random,
        manner: Manner = MANNERS[0],
        is_first: bool = True,
    ) -> None:
        self.path, self.landmarks, self.goal, self.graph, self.random = path, landmarks, goal, graph, random
        self.manner, self.is_first = manner, is_first
        self.start = poses[0]
        # Index -1, a look around at the start, does not count: those landmarks are not seen while walking.
        self._first = {id(landmark): next((n for n in landmark.seen if n >= 0), len(poses)) for landmark in landmarks}
        self.target = next((landmark.label for landmark in landmarks if (landmark.x, landmark.z) == goal), None)
        self.has_twin = sum(landmark.label == self.target for landmark in landmarks) > 1
        self.prefers_groups = random.random() < GROUP_PREFERENCE
        self.geometry = PathGeometry(path, self.start.heading, goal)
        self._by_kind: dict[str, list[Landmark]] = {}
        self._places: dict[str, list[Place]] = {}
        for landmark in landmarks:
            self._places.setdefault(landmark.identity, []).append((landmark.x, landmark.z))
            self._by_kind.setdefault(landmark.label.kind, []).append(landmark)
        self.departures = [0] * len(path)
        place = 0
        for number, pose in enumerate(poses):
            while place + 1 < len(path) and (pose.x, pose.z) != path[place]:
                place += 1
            self.departures[place] = number

    @property
    def last(self) -> int:
        """Index of the path's last place."""
        return len(self.path) - 1

    def of_kind(self, kind: str) -> Sequence[Landmark]:
        """Return the landmarks of a kind, in the order of `landmarks`; only these can share a name."""
        return self._by_kind.get(kind, ())

    def first_seen(self, landmark: Landmark) -> int:
        """Return the index of the first pose from which a landmark is seen; the number of poses if there is none."""
        return self._first[id(landmark)]

    def is_seen(self, landmark: Landmark, waypoint: Waypoint) -> bool:
        """Return whether a landmark is seen before the walker leaves a waypoint."""
        return self.first_seen(landmark) <= self.departures[waypoint.number]

    def option(
        self, waypoint: Waypoint, turns: tuple[Step, ...], step: Step, end: Pose, cost: float
    ) -> Iterator[StepOption]:
        """Yield these steps as an option if they advance along the path."""
        number = self.nearest(end, waypoint.number)
        if number < waypoint.number + 2 and number < self.last:
            return
        here = waypoint.pose.x, waypoint.pose.z
        off = math.dist((end.x, end.z), self.path[number])
        strayed = max_deviation(self.path, waypoint.number, number, here, (end.x, end.z))
        if off > PLANNED_DEVIATION or strayed > PLANNED_DEVIATION:
            return
        if isinstance(step, Walk) and step.things:
            step = replace(step, straight=self._is_straight(waypoint, turns, end), far=self._is_far(waypoint, step))
        gain = min(number - waypoint.number, 14)
        onward = self.onward_heading(number)
        wrong = 0.0 if onward is None else max(abs(turn_between(end.heading, onward)) - 15.0, 0.0) / 25.0
        total = cost + 0.8 * off + 0.5 * strayed - 0.4 * gain + 1.2 * len(turns) + wrong + 1.5 * self.random.random()
        about = next((thing.identity for thing in things_of(step)), "")
        pose = self._on_path(end, number, step)
        yield StepOption(total, (*turns, step), Waypoint(pose, number, isinstance(step, Rotate), about))

    def _on_path(self, end: Pose, number: int, step: Step) -> Pose:
        """Return the pose after a step, its course aligned with the path unless they differ by more than SNAP."""
        before, here = self.path[max(number - 3, 0)], self.path[number]
        is_turn = isinstance(step, Rotate) or before == here
        course = self.onward_heading(number, 3) if is_turn else bearing(before, here)
        if course is None or abs(turn_between(end.heading, course)) > SNAP:
            return end
        return Pose(end.x, end.z, course)

    def _is_far(self, waypoint: Waypoint, step: Walk) -> bool:
        """Return whether a step's thing is far from the waypoint."""
        here = waypoint.pose.x, waypoint.pose.z
        places = [place for thing in step.things for place in self._places.get(thing.identity, ())]
        return bool(places) and min(math.dist(here, place) for place in places) >= PLANNED_FAR

    def _is_straight(self, waypoint: Waypoint, turns: tuple[Step, ...], end: Pose) -> bool:
        """Return whether a step's end is straight ahead of the walker's course and of the path before and after."""
        here = waypoint.pose.x, waypoint.pose.z
        towards = bearing(here, (end.x, end.z))
        onward = self.onward_heading(waypoint.number, 3)
        came = self.geometry.heading_before(waypoint.number) if waypoint.number else None
        courses = [waypoint.pose.heading, onward, None if turns or waypoint.turned else came]
        return all(course is None or abs(turn_between(course, towards)) <= PLANNED_STRAIGHT for course in courses)

    def nearest(self, pose: Pose, since: int) -> int:
        """Return the index of the place in the path nearest to a pose, from `since` on."""
        return self.geometry.nearest((pose.x, pose.z), since, since + MAX_STEP_LENGTH - 1)

    def onward_heading(self, number: int, far: int = 5) -> float | None:
        """Return the direction of the path from a place over its next `far` places; None at its end."""
        if number < self.last:
            return wrap(self.geometry.heading_after(number, far))
        return None if self.path[number] == self.goal else self.geometry.heading_after(number)


def path_turns_by(route: DescribedRoute, waypoint: Waypoint, words: tuple[str, ...]) -> bool:
    """Return whether the path turns at a waypoint as the words say; without words, whether it hardly turns."""
    onward = route.onward_heading(waypoint.number)
    if onward is None:
        return not words
    turned = turn_between(waypoint.pose.heading, onward)
    return turn_word(turned) == words[0] and abs(turned) >= 12.0 if words else abs(turned) <= PLANNED_SLIGHT


def turn_word(degrees: float) -> str:
    """Return the name in `meaning.TURNS` of a turn by this many degrees, positive clockwise."""
    side = "right" if degrees > 0.0 else "left"
    if abs(degrees) >= PLANNED_AROUND:
        return "around"
    return f"slightly {side}" if abs(degrees) <= PLANNED_SLIGHT else side


def pose_after_passing(pose: Pose, x: float, z: float, beyond: float) -> Pose:
    """Return the pose after passing a place."""
    right, ahead = pose.local(x, z)
    aside = right - min(max(right, -PASSED_WITHIN), PASSED_WITHIN)
    course = pose.turned(math.degrees(math.atan2(aside, max(ahead, 0.5))))
    return course.ahead(course.local(x, z)[1] + beyond)


def turn_towards(off: float) -> tuple[str, ...] | None:
    """Return the turn that brings a landmark at this angle to the course into view, or None if there is none."""
    if abs(off) <= PLANNED_IN_VIEW:
        return ()
    word = turn_word(off)
    return (word,) if abs(turn_between(DEGREES[word], off)) <= PLANNED_IN_VIEW else None
