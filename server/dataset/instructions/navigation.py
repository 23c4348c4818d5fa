"""Planning of navigation instructions: steps in no language, from the ground truth's path and the landmarks along it.

A plan is a sequence of steps from landmark to landmark and from place to place. Each step's end is predicted with the
follower's semantics (agents/follower/navigation.py), and the next step is planned from there.
"""

import math
from collections.abc import Sequence
from random import Random

from lang.meaning import Face, Navigation, Rotate, Step, Thing, Walk
from lang.street import DEGREES
from server.dataset.instructions.navigation_choice import fits, full_name
from server.dataset.instructions.navigation_landmarks import landmark_options
from server.dataset.instructions.navigation_legs import Place, bearing, max_deviation, turn_between
from server.dataset.instructions.navigation_names import distinguish
from server.dataset.instructions.navigation_places import place_options
from server.dataset.instructions.navigation_route import MAX_DEVIATION, Option, Route, Waypoint, turn_towards
from server.dataset.instructions.navigation_target import describe
from server.dataset.instructions.sight import Landmark
from server.dataset.plans.graph import StreetGraph
from server.sim.geometry import Pose
from server.sim.rules import Collectible

MAX_COUNT, SHORT_COUNT = 14, 8
"""Maximum count of paces, and the count used instead if more are needed, after which a landmark is sought."""

COUNTED_SHARE = 0.1
"""Probability that a plan may count paces where there is no landmark: people hardly ever do."""

MAX_STEPS = 9
"""Maximum number of steps of a plan."""

UNTIL_SEEN = 0.45
"""Probability that a walk straight to the target is told by it: "walk until you see the mug"."""

ALONG_STREET = 0.12
"""Probability that a walk down a street is told before what comes on it."""

FACE_FIRST = 0.6
"""Probability that the first turn is told by what one then faces, where that is clear."""


def plan_navigation(
    path: Sequence[Place],
    poses: Sequence[Pose],
    target: Collectible,
    street: Sequence[Collectible],
    marks: Sequence[Landmark],
    random: Random,
    graph: StreetGraph | None = None,
) -> Navigation | None:
    """Return the meaning of an instruction to walk a path, or None if no plan leads there.

    Args:
        path: distinct positions (x, z) of the ground truth.
        poses: along the path, from `sight.poses_along`.
        target: the object to pick up at the end.
        street: all collectibles of the turn, including the target.
        marks: result of `sight.find_landmarks` for the poses; can be reused for many draws.
        random: draws the wording; another draw gives another plan.
        graph: of the section's streets, whose places are named; None to name none by what they look like.
    """
    thing = describe(target, street, marks, poses, random)
    if thing is None:
        return None
    route = Route(path, poses, marks, (target.position.x, target.position.z), graph, random)
    steps = _Planner(route, thing).steps()
    if steps is None:
        return None
    full_names = {mark.identity: full_name(mark) for mark in marks if mark.identity}
    return distinguish(Navigation(steps, thing), full_names, random)


class _Planner:
    """Builds the steps of a plan."""

    def __init__(self, route: Route, target: Thing) -> None:
        self._route, self._target, self._random = route, target, route.random
        self._around = [mark for mark in route.marks if mark.glimpsed is not None and mark.glimpsed <= 0]
        seen = [route.first_seen(mark) for mark in route.marks if (mark.x, mark.z) == route.goal]
        self._target_seen = min(seen, default=math.inf)
        self._may_count = self._random.random() < COUNTED_SHARE

    def steps(self) -> tuple[Step, ...] | None:
        """Return all steps, or None if there are too many."""
        route = self._route
        steps: list[Step] = []
        waypoint = Waypoint(route.start, 0)
        while len(steps) <= MAX_STEPS:
            last = self._final_steps(waypoint)
            if last is not None and not (steps and self._may_say_more(waypoint)):
                return (*steps, *last)
            options = [*place_options(route, waypoint), *landmark_options(route, waypoint)]
            if last is not None:
                options = [o for o in options if len(o.steps) == 1 and not isinstance(o.steps[0], Rotate)]
                if not options:
                    return (*steps, *last)
            if not options and not self._may_count:
                return None
            options = options or [self._counted_steps(waypoint)]
            chosen = min(options, key=lambda option: option.cost)
            steps += self._with_facing(chosen) if not steps else (*self._along_street(waypoint, chosen), *chosen.steps)
            waypoint = chosen.waypoint
            if waypoint.number >= route.last and self._final_steps(waypoint) is None:
                return tuple(steps)
        return None

    def _may_say_more(self, waypoint: Waypoint) -> bool:
        far = math.dist((waypoint.pose.x, waypoint.pose.z), self._route.goal)
        return far > 9.0 and self._random.random() < 0.3

    def _final_steps(self, waypoint: Waypoint) -> tuple[Step, ...] | None:
        """Return the remaining steps if the target comes into view, else None."""
        route = self._route
        here = waypoint.pose.x, waypoint.pose.z
        soon = min(waypoint.number + 1, route.last)
        if self._target_seen > route.departures[soon]:
            return None
        if max_deviation(route.path, waypoint.number, route.last, here, route.goal) > MAX_DEVIATION:
            return None
        off = turn_between(waypoint.pose.heading, bearing(here, route.goal))
        words = turn_towards(off)
        if words is None or (words and waypoint.turned):
            return None
        turns = tuple(Rotate(word) for word in words)
        far = math.dist(here, route.goal)
        if far > 4.0 and self._target.look and self._random.random() < UNTIL_SEEN:
            way = self._random.choice(("until", "to", "towards", "until") if abs(off) < 25.0 else ("to", "towards"))
            return (*turns, Walk(way, (self._target,)))
        return turns

    def _along_street(self, waypoint: Waypoint, option: Option) -> tuple[Step, ...]:
        """Return a walk down the street that the last turn led into, sometimes; nothing where it is not clear."""
        graph, step = self._route.graph, option.steps[-1]
        is_on = (isinstance(step, Walk) and step.way == "past") or (isinstance(step, Rotate) and step.at != "")
        if graph is None or not waypoint.turned or not is_on or len(option.steps) > 1:
            return ()
        roads = graph.roads_at(waypoint.pose.x, waypoint.pose.z)
        if self._random.random() > ALONG_STREET or len(roads) != 1:
            return ()
        return (Walk("along", (Thing(roads[0].kind, identity=roads[0].identity),)),)

    def _counted_steps(self, waypoint: Waypoint) -> Option:
        """Return a continuation by counted paces to the next corner, for use without a landmark."""
        route = self._route
        here = waypoint.pose.x, waypoint.pose.z
        corner = next((c for c in route.corners if c > waypoint.number + 1), route.last)
        rotation = turn_between(waypoint.pose.heading, bearing(here, route.path[corner]))
        words: tuple[str, ...] = ()
        while abs(rotation) > 18.0:
            word = min(DEGREES, key=lambda w: abs(turn_between(DEGREES[w], rotation)))
            words, rotation = (*words, word), turn_between(DEGREES[word], rotation)
        count = max(round(math.dist(here, route.path[corner])), 1)
        if count > MAX_COUNT:
            count = SHORT_COUNT
        pose = waypoint.pose.turned(sum(DEGREES[word] for word in words)).ahead(count)
        number = corner if count != SHORT_COUNT else route.nearest(pose, waypoint.number + 1)
        return Option(0.0, (*(Rotate(word) for word in words), Walk("ahead", count=count)), Waypoint(pose, number))

    def _with_facing(self, option: Option) -> tuple[Step, ...]:
        """Return the option's steps, with the first turn sometimes expressed as facing a landmark."""
        if len(option.steps) < 2 or self._random.random() > FACE_FIRST:
            return option.steps
        after = option.steps[-1]
        things = after.things if isinstance(after, Walk) else (after.thing,) if isinstance(after, Rotate) else ()
        thing = things[0] if things else None
        if thing is None or thing.number or sum(fits(thing, mark) for mark in self._around) != 1:
            return option.steps
        return (Face(thing), after)
