"""Planning of navigation instructions: language-independent steps that describe the ground-truth path.

A plan is a sequence of steps from landmark to landmark and from place to place. Each step's end is predicted with the
follower's semantics (agents/follower/navigation.py), and the next step is planned from there. The planner searches
depth first, cheapest step first, and skips steps that the check rejects.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from random import Random
from typing import Protocol

from arramon_client.world import COLLECTIBLES, bearing, turn_between
from arramon_dataset.instructions.navigation.distinct_names import with_distinct_names
from arramon_dataset.instructions.navigation.landmark_names import full_name, name_matches
from arramon_dataset.instructions.navigation.landmark_steps import PLACES as OPEN_PLACES
from arramon_dataset.instructions.navigation.landmark_steps import UNNAMED_BUILDING, landmark_options
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
from arramon_lang.coreference import mentions, things_of
from arramon_lang.meaning import PLACES, Face, Navigation, Rotate, Step, Thing, Walk
from arramon_lang.street_words import DEGREES
from arramon_lang.writing.voice import MANNERS, Manner
from arramon_server.sim.geometry import Pose
from arramon_server.sim.rules import Collectible

AHEAD = 8
"""Maximum length of a walk straight ahead without a landmark at its end, in steps."""

STREETS = ("street", "alley", "building_corner")
"""Places that one turns into or around, and does not walk to first."""

CROSSINGS = ("intersection", "t_junction", "zebra_crossing", "square")
"""Kinds of places with corners of their own."""

NEVER_REACHED = ("building", "zebra_crossing", "you")
"""Kinds that no text leads to before it names the target."""

MAX_STEPS = 9
"""Maximum number of steps of a plan."""

TRIED = 16
"""Maximum number of partial plans to extend before planning fails."""

UNTIL_SEEN = 0.4
"""Probability that a final straight walk refers to the target: "walk until you see the mug"."""

ALONG_STREET = 0.15
"""Probability of "walk down the street" before the first landmark on a street."""

ENTERED_WITHIN = 4
"""Number of places of the path after a turn within which one is on the street that it leads into."""

AHEAD_FIRST = 0.6
"""Probability of "go forward" between a turn and a further one at a landmark."""

AHEAD_FOR = 5
"""Minimum number of places of the path from one turn to the next for "go forward" between them."""

MORE_SHARE = 0.03
"""Probability of another intermediate step although the target, far off, is already visible."""

FACE_FIRST, FACE_AFTER = 0.7, 0.95
"""Probabilities that the first turn is described by the landmark to face, where that is unambiguous: in an episode's
first turn, and in its second, at whose start a walker's heading may be another."""

FACE_ANOTHER, FACE_ANOTHER_AFTER = 0.15, 0.5
"""Probabilities that it is described by another landmark that lies ahead after the turn, if the next step names none
that can be faced; in the same two turns."""

FACED_OFF, FACED_FROM = 15.0, 4.0
"""Maximum angle of that landmark to the path after the turn, in degrees, and its minimum distance."""

TURN_TO_FACE, TURN_TO_FACE_AFTER = 0.95, 0.8
"""Probabilities that it is described by its direction as well, "turn left to face the bench", in the same two turns."""

LOST_COST = 4.0
"""Additional cost of a second turn's text that begins with a turn whose direction depends on the walker's heading."""

TOWARDS_UNFACED = 0.6
"""Probability of "turn left and walk towards it" rather than "turn left to face it, and walk towards it"."""

REACH_FIRST = 0.18
"""Probability of a walk to a thing and a turn there, rather than a turn at it."""

SEE_FIRST = 0.1
"""The same for "until you see a bench" before a turn at it."""

SEEN_SHARE = 0.1
"""Probability of a walk until a thing is seen, and a turn, rather than a turn at it."""

PASSED_SHARE = 0.15
"""Probability of a walk past a thing, and a turn, rather than a turn after it."""

UNMARKED_SHARE = 0.15
"""Probability of "go forward and turn left" rather than a turn at a street or a corner, where there is only one."""

PAIR_SHARE = 0.35
"""Probability of two things on the way together: "past the cone and the bench"."""

PAIR_COST = -2.0
"""Additional cost of such a pair."""

TO_LANDMARK = 0.3
"""Probability of a walk to the landmark that locates the target: "go to the bench and pick up the mug next to it"."""


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
    manner: Manner = MANNERS[0],
    is_first: bool = True,
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
        manner: how much to say.
        is_first: whether it is the episode's first turn, at whose start the walker's heading is known.
    """
    route = DescribedRoute(
        path, poses, landmarks, (target.position.x, target.position.z), graph, random, manner, is_first
    )
    for must_place in (False, True):
        thing = describe_target(target, street, landmarks, poses, random, must_place=must_place)
        if thing is None:
            return None
        planner = _Planner(route, thing)
        steps = planner.steps(plan_check or AcceptAllSteps())
        if steps is None:
            return None
        meaning = Navigation(steps, thing)
        if is_first or thing.where or not _is_bare(steps):
            break
    else:
        if not planner.sees_target_after_turning:
            return None
    full_names = {
        landmark.identity: full_name(landmark) for landmark in landmarks if landmark.label.kind not in OPEN_PLACES
    }
    return with_distinct_names(meaning, full_names, random)


class _Planner:
    """Builds the steps of a plan."""

    def __init__(self, route: DescribedRoute, target: Thing) -> None:
        self._route, self._target, self._random = route, target, route.random
        self._around = [
            landmark for landmark in route.landmarks if landmark.glimpsed is not None and landmark.glimpsed <= 0
        ]
        seen = [route.first_seen(landmark) for landmark in route.landmarks if (landmark.x, landmark.z) == route.goal]
        self._target_seen = min(seen, default=math.inf)

    @property
    def sees_target_after_turning(self) -> bool:
        """Whether the target is in view once the walker has made the turns at the start."""
        return self._target_seen <= self._route.departures[0]

    def steps(self, plan_check: PlanCheck) -> tuple[Step, ...] | None:
        """Return all steps to the target, or None if the search fails."""
        self._left = TRIED
        start = Waypoint(self._route.start, 0)
        slight = self._slight_turn(start)
        check = plan_check.after((slight,)) if slight is not None else None
        if slight is not None and check is not None:
            turned = replace(start, pose=start.pose.turned(DEGREES[slight.direction]), turned=True)
            steps = self._from(turned, (slight,), check)
            if steps is not None:
                return steps
            self._left = TRIED
        return self._from(start, (), plan_check)

    def _slight_turn(self, start: Waypoint) -> Rotate | None:
        """Return the slight turn with which the episode's first path begins; None if it does not."""
        onward = self._route.onward_heading(0)
        if onward is None or not self._route.is_first:
            return None
        word = turn_word(turn_between(start.pose.heading, onward))
        return Rotate(word) if word.startswith("slightly") and path_turns_by(self._route, start, (word,)) else None

    def _from(self, waypoint: Waypoint, steps: tuple[Step, ...], plan_check: PlanCheck) -> tuple[Step, ...] | None:
        """Return a complete plan that extends `steps`, which end at the waypoint; None if there is none."""
        if not self._left or len(steps) > MAX_STEPS:
            return None
        self._left -= 1
        last = next((last for last in self._final_steps(waypoint) if self._may_end(plan_check, last)), None)
        if last is not None and not (steps and self._may_say_more(waypoint)):
            return (*steps, *last)
        options = self._options(waypoint, is_optional=last is not None)
        for option in sorted(options, key=lambda option: _is_vague(steps, option.steps[0])):
            if option.steps[-1] == Walk("ahead") == next(reversed(steps), None) or _is_unclear(steps, option.steps[0]):
                continue
            if last is not None and _is_vague(steps, option.steps[0]):
                break
            for wording in self._wordings(waypoint, option, is_first=not steps):
                repeats = is_doubled(steps, wording[0])
                after = None if repeats or self._mixes((*steps, *wording)) else plan_check.after(wording)
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
        found = [*place_options(route, waypoint), *landmark_options(route, waypoint)]
        if waypoint.number == 0 and not route.is_first:
            found = [replace(o, cost=o.cost + LOST_COST * self._depends_on_heading(o)) for o in found]
        options = sorted([*found, *self._pairs(found)], key=lambda o: o.cost)
        if is_optional:
            return [o for o in options if len(o.steps) == 1 and not isinstance(o.steps[0], Rotate)]
        ahead = self._ahead(waypoint)
        return options if ahead is None else [*options, ahead]

    def _wordings(self, waypoint: Waypoint, option: StepOption, *, is_first: bool) -> list[tuple[Step, ...]]:
        """Return alternative wordings of an option's steps: elaborate, plain, and without the stated side."""
        wording = self._with_facing(option) if is_first else option.steps
        approached = self._approached(wording)
        onward = self._onward(waypoint, option, wording) if approached == wording else approached
        wordings = [onward, wording, option.steps]
        step = option.steps[-1]
        if (
            isinstance(step, Walk) and step.way == "past" and step.side
        ):  # Where the side is refused, the rest may be so.
            wordings.append((*option.steps[:-1], replace(step, side="")))
        return list(dict.fromkeys(wordings))

    def _pairs(self, options: list[StepOption]) -> list[StepOption]:
        """Return walks past two things, one after the other."""
        if self._random.random() > PAIR_SHARE * self._route.manner.says_more:
            return []
        passing = [o for o in options if isinstance(o.steps[-1], Walk) and _is_plain_passing(o.steps[-1])]
        return [
            replace(
                far,
                cost=far.cost + PAIR_COST,
                steps=(*near.steps[:-1], *_without_side((near.steps[-1], far.steps[-1]))),
            )
            for near in passing
            for far in passing
            if near.steps[:-1] == far.steps[:-1] and near.waypoint.number < far.waypoint.number
        ]

    def _depends_on_heading(self, option: StepOption) -> bool:
        """Return whether an option begins with a turn that no landmark to face can replace."""
        after = option.steps[-1]
        return isinstance(option.steps[0], Rotate) and len(option.steps) > 1 and self._faced(after) is None

    def _approached(self, wording: tuple[Step, ...]) -> tuple[Step, ...]:
        """Return steps with a walk to, past, or until one sees the thing of a turn before that turn, by chance."""
        *before, turn = wording
        if not isinstance(turn, Rotate) or turn.thing is None or turn.thing.kind in STREETS:
            return wording
        plain, drawn = Rotate(turn.direction), self._random.random()
        if turn.at == "after" and drawn < PASSED_SHARE:
            return (*before, Walk("past", (turn.thing,)), plain)
        if turn.at != "at":
            return wording
        if drawn < REACH_FIRST:
            return (*before, Walk("to", (turn.thing,), straight=False), plain)
        if turn.thing.kind in PLACES:
            return (*before, Walk("ahead"), plain) if drawn < REACH_FIRST + UNMARKED_SHARE else wording
        if drawn < REACH_FIRST + SEE_FIRST:
            return (*before, Walk("until", (turn.thing,), straight=False), turn)
        if drawn < REACH_FIRST + SEE_FIRST + SEEN_SHARE:
            return (*before, Walk("until", (turn.thing,), straight=False), plain)
        return wording

    def _may_say_more(self, waypoint: Waypoint) -> bool:
        far = math.dist((waypoint.pose.x, waypoint.pose.z), self._route.goal)
        return far > 9.0 and self._random.random() < MORE_SHARE * self._route.manner.says_more

    def _final_steps(self, waypoint: Waypoint) -> Iterator[tuple[Step, ...]]:
        """Yield final steps, the preferred ones first, if the target comes into view."""
        route = self._route
        here = waypoint.pose.x, waypoint.pose.z
        soon = min(waypoint.number + 1, route.last)
        if self._target_seen > route.departures[soon]:
            return
        if max_deviation(route.path, waypoint.number, route.last, here, route.goal) > PLANNED_DEVIATION:
            return
        off = turn_between(waypoint.pose.heading, bearing(here, route.goal))
        words = turn_towards(off)
        if words is None or (words and waypoint.turned) or not path_turns_by(route, waypoint, words):
            return
        turns = tuple(Rotate(word) for word in words)
        far = math.dist(here, route.goal)
        if self._random.random() < TO_LANDMARK * route.manner.landmarks:
            yield from self._to_landmark(waypoint, turns)
        if far > 4.0 and self._target.look and not route.has_twin and self._random.random() < UNTIL_SEEN:
            way = self._random.choice(("until", "to", "towards", "until") if abs(off) < 25.0 else ("to", "towards"))
            yield (*turns, Walk(way, (self._target,), straight=not turns and abs(off) <= PLANNED_STRAIGHT))
        yield turns

    def _to_landmark(self, waypoint: Waypoint, turns: tuple[Rotate, ...]) -> Iterator[tuple[Step, ...]]:
        """Yield a walk to the landmark that locates the target, if it is in view and ahead after the turns."""
        where = self._target.where[0] if self._target.where else None
        if where is None or len(where.things) > 1 or where.things[0].kind in NEVER_REACHED:
            return
        thing, route, here = where.things[0], self._route, (waypoint.pose.x, waypoint.pose.z)
        ends = [landmark for landmark in route.landmarks if landmark.identity in thing.identity.split("+")]
        if not ends or not all(route.is_seen(landmark, waypoint) for landmark in ends):
            return
        towards = [turn_towards(turn_between(waypoint.pose.heading, bearing(here, (m.x, m.z)))) for m in ends]
        nearest = min(math.dist(here, (landmark.x, landmark.z)) for landmark in ends)
        if nearest > 4.5 and all(words == tuple(turn.direction for turn in turns) for words in towards):
            ways = ("to", "to", "to", "towards", "until", "until") if not thing.number else ("to", "towards")
            yield (*turns, Walk(self._random.choice(ways), (thing,), straight=False))

    def _onward(self, waypoint: Waypoint, option: StepOption, wording: tuple[Step, ...]) -> tuple[Step, ...]:
        """Return steps with a walk down the street, or just ahead, between a turn and their last step, by chance.

        It is always said before a turn at another thing than the one that one faces.
        """
        *before, last = wording
        if (
            before
            and isinstance(before[-1], Face)
            and isinstance(last, Rotate)
            and last.thing not in (None, before[-1].thing)
        ):
            return (*before, Walk("ahead"), last)
        is_turned = isinstance(before[-1], Rotate) if before else waypoint.turned
        is_turn = isinstance(last, Rotate) and last.at != ""
        if not is_turned or not (is_turn or (isinstance(last, Walk) and last.way == "past")):
            return wording
        street = self._street_entered(waypoint)
        if street is not None and self._random.random() < ALONG_STREET:
            return (*before, Walk("along", (street,)), last)
        is_far = option.waypoint.number >= waypoint.number + AHEAD_FOR
        if is_turn and is_far and self._random.random() < AHEAD_FIRST:
            return (*before, Walk("ahead"), last)
        return wording

    def _street_entered(self, waypoint: Waypoint) -> Thing | None:
        """Return the street on which the path goes on; None if there is none, or several."""
        graph, route = self._route.graph, self._route
        if graph is None:
            return None
        roads = graph.roads_at(*route.path[min(waypoint.number + ENTERED_WITHIN, route.last)])
        return Thing(roads[0].kind, identity=roads[0].identity) if len(roads) == 1 else None

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
        share = FACE_FIRST * self._route.manner.landmarks if self._route.is_first else FACE_AFTER
        if len(option.steps) < 2:
            return option.steps
        thing = None if is_turn_at or self._random.random() > share else self._faced(after)
        turn = option.steps[0]
        is_towards = isinstance(after, Walk) and after.way == "towards"
        if thing is None and not is_towards:
            thing = self._faced_instead(option)
        if thing is None or (is_towards and self._random.random() < TOWARDS_UNFACED):
            return option.steps
        is_said = self._random.random() < (TURN_TO_FACE if self._route.is_first else TURN_TO_FACE_AFTER)
        return (turn, Face(thing), *option.steps[1:]) if is_said else (Face(thing), *option.steps[1:])

    def _faced_instead(self, option: StepOption) -> Thing | None:
        """Return a landmark ahead, to face before a walk or turn at another one, by chance; None if there is none."""
        route, here = self._route, self._route.path[0]
        onward, named = route.onward_heading(0), {thing.identity for step in option.steps for thing in things_of(step)}
        share = FACE_ANOTHER * route.manner.landmarks if route.is_first else FACE_ANOTHER_AFTER
        if onward is None or self._random.random() > share:
            return None
        ahead = [
            landmark
            for landmark in self._around
            if landmark.label.kind not in (*COLLECTIBLES, *OPEN_PLACES, *PLACES, "zebra_crossing")
            and landmark.label != UNNAMED_BUILDING
            and landmark.identity not in named
            and math.dist(here, (landmark.x, landmark.z)) >= FACED_FROM
            and abs(turn_between(onward, bearing(here, (landmark.x, landmark.z)))) <= FACED_OFF
        ]
        names = (full_name(each) for each in sorted(ahead, key=lambda each: math.dist(here, (each.x, each.z))))
        return next((name for name in names if self._is_only_one(name)), None)

    def _is_only_one(self, name: Thing) -> bool:
        """Return whether a name fits just one of the landmarks around the start."""
        return sum(name_matches(name, landmark) for landmark in self._around) == 1

    def _faced(self, step: Step) -> Thing | None:
        """Return the thing to face before a step; None if it has none, or another one looks alike."""
        things = step.things if isinstance(step, Walk) else (step.thing,) if isinstance(step, Rotate) else ()
        thing = things[0] if things else None
        if thing is None or thing.number or thing.kind in PLACES or not self._is_only_one(thing):
            return None
        return thing


def _is_plain_passing(step: Walk) -> bool:
    """Return whether a walk is past one thing that can be named together with another."""
    thing = step.things[0] if step.things else Thing("")
    return step.way == "past" and not thing.number and not thing.which and thing.kind not in (*PLACES, "zebra_crossing")


def is_doubled(steps: tuple[Step, ...], step: Step) -> bool:
    """Return whether a step repeats the one before.

    "Go forward, go down the street", "go towards the traffic light, go to it".
    """
    last = steps[-1] if steps else None
    if not (isinstance(last, Walk) and isinstance(step, Walk)):
        return False
    is_again = last.way in ("to", "towards") and step.way in ("to", "towards", "until") and step.things == last.things
    return is_again or (last == Walk("ahead") and step.way == "along")


def _is_bare(steps: tuple[Step, ...]) -> bool:
    """Return whether steps name nothing: "turn right, go forward"."""
    return not any(
        (isinstance(step, Rotate) and step.thing is not None) or isinstance(step, Face) or getattr(step, "things", ())
        for step in steps
    )


def _is_unclear(steps: tuple[Step, ...], step: Step) -> bool:
    """Return whether a step turns at "the corner" right after a crossing: before, on or behind it?"""
    last = steps[-1] if steps else None
    is_at_crossing = isinstance(last, Walk) and last.way in ("past", "to") and last.things[0].kind in CROSSINGS
    return is_at_crossing and isinstance(step, Rotate) and step.thing is not None and step.thing.kind == "corner"


def _is_vague(steps: tuple[Step, ...], step: Step) -> bool:
    """Return whether it is only the step itself that says where a walk towards something ends.

    It turns, or heads for another thing, after a walk that only leads towards one: such plans are a last resort.
    """
    last = steps[-1] if steps else None
    if not (isinstance(last, Walk) and last.way == "towards"):
        return False
    is_elsewhere = isinstance(step, Walk) and step.way == "towards" and step.things != last.things
    return is_elsewhere or (isinstance(step, Rotate) and step.thing is None)


def _without_side(steps: tuple[Step, ...]) -> tuple[Step, ...]:
    return tuple(replace(step, side="") if isinstance(step, Walk) else step for step in steps)


def _is_straight(route: DescribedRoute, here: Place, heading: float, number: int) -> bool:
    """Return whether a place of the path is straight ahead."""
    return abs(turn_between(heading, bearing(here, route.path[number]))) < 28.0
