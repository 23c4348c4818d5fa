"""Simulated walks without images: labelled decisions for training the policy, and scores of walks."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from arramon_agents.mapping.body import AgentBody
from arramon_agents.mapping.probabilistic_landmark_memory import LandmarkBelief
from arramon_agents.reading.reader.slots import Row
from arramon_agents.simulated.alignment import current_row, places_of
from arramon_agents.simulated.body import PerceptionErrorRates, SimulatedBody
from arramon_agents.simulated.courses import Course
from arramon_agents.simulated.world_frame import WorldFrame
from arramon_agents.vl_map.features import DIRECTIONS, PolicyInput
from arramon_agents.vl_map.navigator import MapNavigator, OptionValues
from arramon_agents.vl_map.options import DISTANCES, OPTIONS, WAYPOINTS
from arramon_client.agent import Action
from arramon_client.world import REACH_AHEAD, REACH_MARGIN, REACH_SIDE, STEPS_PER_PHASE
from arramon_server.scoring.metrics import ndtw

Choices = npt.NDArray[np.float32]

MAX_LABEL_DISTANCE, MAX_DETOUR_FACTOR, MAX_DETOUR_UNITS = 10.0, 1.3, 2.0
"""Maximum distance of a label, in units; maximum length of the path to it: a factor of its distance, plus units."""

WINDOW, BACK_PENALTY = 20, 0.15
"""Number of path points ahead among which to search the nearest to the agent; penalty per later point, in units."""

TARGET_PATH_LENGTH = 7.0
"""Length of the remaining path below which the label is the target, if the agent has seen it, in units."""

SAME_LANDMARK_DISTANCE = 1.2
"""Maximum distance between a landmark and the target for it to be the target, in units."""


class DecisionLabel(NamedTuple):
    """Label of a decision.

    Attributes:
        right, ahead: place to go to, relative to the agent, in units.
        thing: index of the landmark to pick up; -1 for none.
        row: index of the row that is being carried out.
    """

    right: float
    ahead: float
    thing: int
    row: int


class CourseGuide:
    """Labels decisions of an agent that walks a course.

    Args:
        course: the course.
        rows: rows of the instruction.
        body: body of the agent.
        frame: the agent's initial pose in the world.
    """

    def __init__(self, course: Course, rows: Sequence[Row], body: AgentBody, frame: WorldFrame) -> None:
        self._course, self._rows, self._body, self._frame = course, rows, body, frame
        self._places = places_of(course, rows)
        self._at = 0
        self._trail: list[tuple[float, float]] = []

    def label(self, beliefs: Sequence[LandmarkBelief]) -> DecisionLabel | None:
        """Return the label at the current pose; None if there is none.

        It is farther along the path if possible, otherwise back along the way by which the agent left the path.

        Args:
            beliefs: landmarks in the input of the policy.
        """
        onward = self._onward(beliefs)
        x, z, _ = self._frame.pose_of(self._body)
        if onward is not None:
            self._trail = [(x, z)]
            return onward
        seen = [place for place in self._trail if self._course.world.is_free(x, z, *place)]
        self._trail.append((x, z))
        near = [place for place in seen if 0.7 < math.hypot(place[0] - x, place[1] - z) <= MAX_LABEL_DISTANCE]
        return self._to(near[0], -1) if near else None

    def _onward(self, beliefs: Sequence[LandmarkBelief]) -> DecisionLabel | None:
        course = self._course
        x, z, _ = self._frame.pose_of(self._body)
        path, arcs = course.path, course.arcs
        window = slice(self._at, min(self._at + WINDOW, len(path)))
        away = np.hypot(path[window, 0] - x, path[window, 1] - z) + BACK_PENALTY * np.arange(window.stop - window.start)
        self._at += int(away.argmin())
        if arcs[-1] - arcs[self._at] <= TARGET_PATH_LENGTH:
            thing = self._target(beliefs)
            if thing is not None and course.world.is_free(x, z, *course.target, clearance=0.05):
                return self._to(course.target, thing)
        distances = np.hypot(path[:, 0] - x, path[:, 1] - z)
        for number in range(len(path) - 1, self._at - 1, -1):
            distance = float(distances[number])
            along = float(arcs[number] - arcs[self._at])
            if distance > MAX_LABEL_DISTANCE or along > MAX_DETOUR_FACTOR * distance + MAX_DETOUR_UNITS:
                continue
            if distance < 0.7 and number == len(path) - 1:
                return self._to(course.target, -1)
            if course.world.is_free(x, z, *path[number].tolist()):
                return self._to(tuple(path[number].tolist()), -1)
        return None

    def back(self) -> DecisionLabel:
        """Return the label that leads back to the nearest point of the path."""
        return self._to(tuple(self._course.path[self._at].tolist()), -1)

    def _target(self, beliefs: Sequence[LandmarkBelief]) -> int | None:
        course = self._course
        near = []
        for number, belief in enumerate(beliefs):
            x, z = self._frame.to_world(belief.mark.x, belief.mark.z)
            far = math.hypot(x - course.target[0], z - course.target[1])
            if far < SAME_LANDMARK_DISTANCE and belief.mark.label.kind == course.items[0].type.kind:
                near.append((far, number))
        return min(near)[1] if near else None

    def _to(self, place: tuple[float, ...], thing: int) -> DecisionLabel:
        right, ahead = self._body.to_local(*self._frame.to_own(place[0], place[1]))
        return DecisionLabel(right, ahead, thing, current_row(self._rows, self._places, self._at))


class LabelledDecision(NamedTuple):
    """A training example of the policy: input and label of a decision."""

    sample: PolicyInput
    label: DecisionLabel


class RecordedPolicy:
    """Policy of a walk that records its decisions with their labels.

    Args:
        guide: labels the decisions.
        random: random generator of detours.
        option_values: the policy; None to follow the labels.
        astray: share of decisions that deviate: from the label, or from the policy to the label.

    Attributes:
        decisions: the decisions so far that have a label.
    """

    def __init__(
        self, guide: CourseGuide, random: np.random.Generator, option_values: OptionValues | None, astray: float
    ) -> None:
        self._guide, self._random, self._option_values, self._astray = guide, random, option_values, astray
        self.decisions: list[LabelledDecision] = []

    def __call__(self, sample: PolicyInput, beliefs: Sequence[LandmarkBelief]) -> Choices:
        """Return a score for each option, and record the decision."""
        label = self._guide.label(beliefs)
        if label is not None:
            self.decisions.append(LabelledDecision(sample, label))
        if self._option_values is not None and self._random.random() >= self._astray:
            return self._option_values(sample, beliefs)
        followed = label or self._guide.back()
        if self._option_values is None and self._random.random() < self._astray:
            return _near(followed, self._random)
        return _exactly(followed)


@dataclass(frozen=True)
class WalkResult:
    """A finished walk.

    Attributes:
        path: (n, 2) of distinct positions (x, z) in the world.
        picked: index of the collectible that was picked up; None if there was no pick-up.
        decisions: decisions that have a label.
        body: body of the agent at the end.
    """

    path: npt.NDArray[np.float64]
    picked: int | None
    decisions: Sequence[LabelledDecision]
    body: SimulatedBody


def walk(
    course: Course,
    rows: Sequence[Row],
    faults: PerceptionErrorRates,
    random: np.random.Generator,
    option_values: OptionValues | None = None,
    astray: float = 0.3,
    body: SimulatedBody | None = None,
) -> WalkResult:
    """Simulate a walk of a course.

    Args:
        course: the course.
        rows: rows of the instruction.
        faults: error rates of perception.
        random: random generator of errors and detours.
        option_values: the policy; None to follow the labels.
        astray: as for `RecordedPolicy`.
        body: body of the previous turn, to continue from its pose; None to begin at the course's start.
    """
    if body is None:
        body = SimulatedBody(course.world, course.things, course.start, faults, random)
    else:
        body.begin_turn(course.things)
    guide = CourseGuide(course, rows, body, body.frame)
    policy = RecordedPolicy(guide, random, option_values, astray)
    navigator = MapNavigator(body, rows, policy, course.turn)
    path, picked = act_until_picked(course, body, navigator.act)
    return WalkResult(np.array(path), picked, policy.decisions, body)


def act_until_picked(
    course: Course, body: SimulatedBody, act: Callable[[int], Action]
) -> tuple[list[tuple[float, float]], int | None]:
    """Play the navigation phase of a course until an object is picked up or no step is left.

    Args:
        course: the course.
        body: the agent's body.
        act: returns the next action from the number of steps that are left.

    Returns:
        The distinct positions (x, z) in units, and the index of the object; None if none was picked up.
    """
    path = [body.frame.to_world(body.x, body.z)]
    for left in range(STEPS_PER_PHASE, 0, -1):
        body.observe()
        action = act(left)
        if action is Action.INTERACT:
            picked = picked_item(course, body)
            if picked is not None:
                return path, picked
            body.record_action(None)
            continue
        body.apply(action)
        here = body.frame.to_world(body.x, body.z)
        if math.dist(here, path[-1]) > 1e-6:
            path.append(here)
    return path, None


def picked_item(course: Course, body: SimulatedBody) -> int | None:
    """Return the index of the nearest collectible in the pick-up box; None if there is none."""
    found = []
    for number, item in enumerate(course.items):
        right, ahead = body.to_local(*body.frame.to_own(item.position.x, item.position.z))
        if abs(right) <= REACH_SIDE + REACH_MARGIN and -REACH_MARGIN <= ahead <= REACH_AHEAD + REACH_MARGIN:
            found.append((math.hypot(right, ahead), number))
    return min(found)[1] if found else None


def _exactly(label: DecisionLabel) -> Choices:
    """Return option scores that follow a label exactly."""
    values = np.full(OPTIONS, -50.0, np.float32)
    if label.thing >= 0:
        values[WAYPOINTS + label.thing] = 50.0
    direction = math.atan2(label.right, label.ahead) / (2.0 * math.pi / DIRECTIONS)
    distance = math.hypot(label.right, label.ahead)
    for number in range(WAYPOINTS):
        there, far = divmod(number, len(DISTANCES))
        apart = abs((there - direction + DIRECTIONS / 2) % DIRECTIONS - DIRECTIONS / 2)
        values[number] = -apart - abs(math.log(DISTANCES[far] / max(distance, 0.8)))
    return values


def _near(label: DecisionLabel, random: np.random.Generator) -> Choices:
    """Return option scores that follow a label with a random deviation, sometimes in any direction."""
    angle = random.normal(0.0, 0.5) if random.random() < 0.75 else random.uniform(-math.pi, math.pi)
    sin, cos = math.sin(angle), math.cos(angle)
    far = random.uniform(0.3, 1.2)
    right, ahead = label.right * cos + label.ahead * sin, label.ahead * cos - label.right * sin
    return _exactly(label._replace(right=far * right, ahead=far * ahead, thing=-1))


def score(
    courses: Sequence[Course], option_values: OptionValues, reading: int, faults: PerceptionErrorRates, seed: int = 0
) -> dict[str, float]:
    """Return mean scores of a policy: nDTW, success of the pick-up, CTC-3 (the walk ends within 3 units of the target).

    Args:
        courses: courses of the turns of episodes, in order; a second turn begins where the first one ended.
        option_values: the policy.
        reading: index of the reading to follow.
        faults: error rates of perception.
        seed: seed of the errors.
    """
    rows: list[tuple[float, float, float]] = []
    body = None
    for number, course in enumerate(courses):
        draws = np.random.default_rng((seed, number))
        rows_read = course.readings[min(reading, len(course.readings) - 1)]
        walked = walk(course, rows_read, faults, draws, option_values, 0.0, body if course.turn > 1 else None)
        body = walked.body
        far = float(np.hypot(*(walked.path[-1] - course.target)))
        value = ndtw([tuple(p) for p in walked.path.tolist()], [tuple(p) for p in course.path.tolist()])
        rows.append((value, float(walked.picked == 0), float(far < 3.0)))
    means: npt.NDArray[np.float64] = np.array(rows).mean(0)
    return dict(zip(("nDTW", "picked", "CTC-3"), means.round(3).tolist(), strict=True))
