"""Planning of navigation instructions: language-independent steps that describe the ground-truth path.

A plan is a sequence of steps from landmark to landmark and from place to place. Each step's end is predicted with the
follower's semantics (agents/follower/navigation.py), and the next step is planned from there. The planner searches
depth first, cheapest step first, and skips steps that the check rejects.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from random import Random
from typing import Protocol

from arramon_client.world import bearing, turn_between
from arramon_dataset.instructions.navigation.distinct_names import with_distinct_names
from arramon_dataset.instructions.navigation.landmark_names import full_name, name_matches
from arramon_dataset.instructions.navigation.landmark_steps import PLACES as OPEN_PLACES
from arramon_dataset.instructions.navigation.landmark_steps import landmark_options
from arramon_dataset.instructions.navigation.place_steps import place_options
from arramon_dataset.instructions.navigation.route import (
    DescribedRoute,
    StepOption,
    Waypoint,
    path_turns_by,
    turn_towards,
    turn_word,
)
from arramon_dataset.instructions.navigation.target import describe_target
from arramon_dataset.instructions.visible_landmarks import Landmark
from arramon_dataset.path_tolerances import PLANNED_DEVIATION, PLANNED_STRAIGHT
from arramon_dataset.paths import Place, max_deviation
from arramon_dataset.plans.graph import StreetGraph
from arramon_lang.coreference import mentions
from arramon_lang.meaning import PLACES, Face, Navigation, Rotate, Step, Thing, Walk
from arramon_server.sim.geometry import Pose
from arramon_server.sim.rules import Collectible

AHEAD = 8
"""Maximum length of a walk straight ahead without a landmark at its end, in steps."""

MAX_STEPS = 9
"""Maximum number of steps of a plan."""

TRIED = 24
"""Maximum number of partial plans to extend before planning fails."""

UNTIL_SEEN = 0.4
"""Probability that a final straight walk refers to the target: "walk until you see the mug"."""

ALONG_STREET = 0.18
"""Probability of "walk down the street" before the first landmark on a street."""

MORE_SHARE = 0.1
"""Probability of another intermediate step although the target, far off, is already visible."""

FACE_FIRST = 0.6
"""Probability that the first turn is described by the landmark to face, where that is unambiguous."""


class PlanCheck(Protocol):
    """Accepts or rejects the steps of a plan, one after another."""

    def after(self, steps: tuple[Step, ...]) -> "PlanCheck | None":
        """Return the check after further steps; None if it rejects one of them."""

    def may_end(self, target: Thing) -> bool:
        """Return whether the plan may end here: the target's description is true and no step is missing."""


class AcceptAllSteps:
    """A check that accepts every step."""

    def after(self, steps: tuple[Step, ...]) -> "AcceptAllSteps":  # noqa: ARG002 - part of the protocol
        """Return this check."""
        return self

    def may_end(self, target: Thing) -> bool:  # noqa: ARG002 - part of the protocol
        """Return True."""
        return True


def plan_navigation(
    path: Sequence[Place],
    poses: Sequence[Pose],
    target: Collectible,
    street: Sequence[Collectible],
    landmarks: Sequence[Landmark],
    random: Random,
    graph: StreetGraph | None = None,
    plan_check: PlanCheck | None = None,
) -> Navigation | None:
    """Return the meaning of an instruction to walk a path, or None if planning fails.

    Args:
        path: distinct positions (x, z) of the ground truth.
        poses: along the path, from `visible_landmarks.poses_along`.
        target: the object to pick up at the end.
        street: all collectibles of the turn, including the target.
        landmarks: result of `visible_landmarks.find_landmarks` for the poses; can be reused for many draws.
        random: draws the wording; another draw gives another plan.
        graph: of the section's streets; None to call every place a corner.
        plan_check: accepts or rejects steps; None to accept all of them.
    """
    thing = describe_target(target, street, landmarks, poses, random)
    if thing is None:
        return None
    route = DescribedRoute(path, poses, landmarks, (target.position.x, target.position.z), graph, random)
    steps = _Planner(route, thing).steps(plan_check or AcceptAllSteps())
    if steps is None:
        return None
    full_names = {
        landmark.identity: full_name(landmark) for landmark in landmarks if landmark.label.kind not in OPEN_PLACES
    }
    return with_distinct_names(Navigation(steps, thing), full_names, random)


class _Planner:
    """Builds the steps of a plan."""

    def __init__(self, route: DescribedRoute, target: Thing) -> None:
        self._route, self._target, self._random = route, target, route.random
        self._around = [
            landmark for landmark in route.landmarks if landmark.glimpsed is not None and landmark.glimpsed <= 0
        ]
        seen = [route.first_seen(landmark) for landmark in route.landmarks if (landmark.x, landmark.z) == route.goal]
        self._target_seen = min(seen, default=math.inf)

    def steps(self, plan_check: PlanCheck) -> tuple[Step, ...] | None:
        """Return all steps to the target, or None if the search fails."""
        self._left = TRIED
        return self._from(Waypoint(self._route.start, 0), (), plan_check)

    def _from(self, waypoint: Waypoint, steps: tuple[Step, ...], plan_check: PlanCheck) -> tuple[Step, ...] | None:
        """Return a complete plan that extends `steps`, which end at the waypoint; None if there is none."""
        if not self._left or len(steps) > MAX_STEPS:
            return None
        self._left -= 1
        last = self._final_steps(waypoint)
        if last is not None and not self._may_end(plan_check, last):
            last = None
        if last is not None and not (steps and self._may_say_more(waypoint)):
            return (*steps, *last)
        for option in self._options(waypoint, is_optional=last is not None):
            if option.steps[-1] == Walk("ahead") == next(reversed(steps), None):
                continue
            for wording in self._wordings(waypoint, option, is_first=not steps):
                after = None if self._mixes((*steps, *wording)) else plan_check.after(wording)
                if after is not None:
                    whole = self._from(option.waypoint, (*steps, *wording), after)
                    if whole is not None:
                        return whole
                    break
        if last is not None:
            return (*steps, *last)
        return steps if steps and waypoint.number >= self._route.last and plan_check.may_end(self._target) else None

    def _mixes(self, steps: tuple[Step, ...]) -> bool:
        """Return whether steps name both a group and other things of the same kind."""
        named: dict[str, set[str]] = {}
        several = set()
        for thing in mentions(Navigation(steps, self._target)):
            named.setdefault(thing.kind, set()).add(thing.identity)
            if thing.number:
                several.add(thing.kind)
        return any(len(named[kind]) > 1 for kind in several)

    def _may_end(self, plan_check: PlanCheck, last: tuple[Step, ...]) -> bool:
        after = plan_check.after(last)
        return after is not None and after.may_end(self._target)

    def _options(self, waypoint: Waypoint, *, is_optional: bool) -> list[StepOption]:
        """Return the candidate steps at a waypoint, the cheapest first; no turns if the plan could end here."""
        route = self._route
        options = sorted([*place_options(route, waypoint), *landmark_options(route, waypoint)], key=lambda o: o.cost)
        if is_optional:
            return [o for o in options if len(o.steps) == 1 and not isinstance(o.steps[0], Rotate)]
        ahead = self._ahead(waypoint)
        return options if ahead is None else [*options, ahead]

    def _wordings(self, waypoint: Waypoint, option: StepOption, *, is_first: bool) -> list[tuple[Step, ...]]:
        """Return alternative wordings of an option's steps: elaborate, plain, and without the stated side."""
        wording = self._with_facing(option) if is_first else (*self._along_street(waypoint, option), *option.steps)
        wordings = [wording] if wording == option.steps else [wording, option.steps]
        step = option.steps[-1]
        if (
            isinstance(step, Walk) and step.way == "past" and step.side
        ):  # Where the side is refused, the rest may be so.
            wordings.append((*option.steps[:-1], replace(step, side="")))
        return wordings

    def _may_say_more(self, waypoint: Waypoint) -> bool:
        far = math.dist((waypoint.pose.x, waypoint.pose.z), self._route.goal)
        return far > 9.0 and self._random.random() < MORE_SHARE

    def _final_steps(self, waypoint: Waypoint) -> tuple[Step, ...] | None:
        """Return the final steps if the target comes into view, else None."""
        route = self._route
        here = waypoint.pose.x, waypoint.pose.z
        soon = min(waypoint.number + 1, route.last)
        if self._target_seen > route.departures[soon]:
            return None
        if max_deviation(route.path, waypoint.number, route.last, here, route.goal) > PLANNED_DEVIATION:
            return None
        off = turn_between(waypoint.pose.heading, bearing(here, route.goal))
        words = turn_towards(off)
        if words is None or (words and waypoint.turned) or not path_turns_by(route, waypoint, words):
            return None
        turns = tuple(Rotate(word) for word in words)
        far = math.dist(here, route.goal)
        if far > 4.0 and self._target.look and not route.has_twin and self._random.random() < UNTIL_SEEN:
            way = self._random.choice(("until", "to", "towards", "until") if abs(off) < 25.0 else ("to", "towards"))
            return (*turns, Walk(way, (self._target,), straight=not turns and abs(off) <= PLANNED_STRAIGHT))
        return turns

    def _along_street(self, waypoint: Waypoint, option: StepOption) -> tuple[Step, ...]:
        """Return a walk along the street entered by the last turn, drawn at random; () if the street is ambiguous."""
        graph, step = self._route.graph, option.steps[-1]
        is_on = (isinstance(step, Walk) and step.way == "past") or (isinstance(step, Rotate) and step.at != "")
        if graph is None or not waypoint.turned or not is_on or len(option.steps) > 1:
            return ()
        roads = graph.roads_at(waypoint.pose.x, waypoint.pose.z)
        if self._random.random() > ALONG_STREET or len(roads) != 1:
            return ()
        return (Walk("along", (Thing(roads[0].kind, identity=roads[0].identity),)),)

    def _ahead(self, waypoint: Waypoint) -> StepOption | None:
        """Return a walk straight ahead, possibly after a turn, to a place with more in view; None if there is none."""
        route = self._route
        onward = route.onward_heading(waypoint.number, 4)
        if onward is None or waypoint.number >= route.last:
            return None
        rotation = turn_between(waypoint.pose.heading, onward)
        turns: tuple[Step, ...] = ()
        if abs(rotation) > (36.0 if waypoint.turned else 20.0):
            word = turn_word(rotation)
            if waypoint.turned or not path_turns_by(route, waypoint, (word,)):
                return None
            turns = (Rotate(word),)
        here = route.path[waypoint.number]
        number = waypoint.number
        while number < min(waypoint.number + AHEAD, route.last) and _is_straight(route, here, onward, number + 1):
            number += 1
        if number < waypoint.number + 3:
            return None
        pose = Pose(*route.path[number], bearing(here, route.path[number]))
        return StepOption(0.0, (*turns, Walk("ahead")), Waypoint(pose, number, turned=True))

    def _with_facing(self, option: StepOption) -> tuple[Step, ...]:
        """Return the option's steps, with the first turn sometimes replaced by facing a landmark."""
        after = option.steps[-1]
        is_turn_at = isinstance(after, Rotate) and after.at == "at"  # "Face the bin, turn left at that bin."
        if len(option.steps) < 2 or is_turn_at or self._random.random() > FACE_FIRST:
            return option.steps
        things = after.things if isinstance(after, Walk) else (after.thing,) if isinstance(after, Rotate) else ()
        thing = things[0] if things else None
        if (
            thing is None
            or thing.number
            or thing.kind in PLACES
            or sum(name_matches(thing, landmark) for landmark in self._around) != 1
        ):
            return option.steps
        return (Face(thing), after)


def _is_straight(route: DescribedRoute, here: Place, heading: float, number: int) -> bool:
    """Return whether a place of the path is straight ahead."""
    return abs(turn_between(heading, bearing(here, route.path[number]))) < 28.0
