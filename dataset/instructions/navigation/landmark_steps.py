"""Candidate steps that refer to landmarks: walks past, to or between them, and turns at them."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations

from arramon_client.world import COLLECTIBLES, bearing, turn_between
from arramon_dataset.instructions.navigation.groups import NEVER_SEVERAL, LandmarkGroup, group_nearest_to
from arramon_dataset.instructions.navigation.landmark_names import counted_name, unique_name
from arramon_dataset.instructions.navigation.place_steps import MAX_BEND
from arramon_dataset.instructions.navigation.route import (
    MAX_STEP_LENGTH,
    DescribedRoute,
    StepOption,
    Waypoint,
    path_turns_by,
    pose_after_passing,
    turn_towards,
    turn_word,
)
from arramon_dataset.instructions.visible_landmarks import Landmark
from arramon_dataset.path_tolerances import PLANNED_ASIDE, PLANNED_AT
from arramon_lang.meaning import Rotate, Step, Thing, Walk
from arramon_lang.street_words import DEGREES, PAST_DISTANCE, REACHED_WITHIN, TURN_OFFSETS
from arramon_server.sim.geometry import Pose
from arramon_server.sim.labels import SegmentationLabel

AMBIGUITY_COST = 2.0
"""Cost of naming a landmark that could be confused with one not visible from the path."""

COLLECTIBLE_COST, BUILDING_COST, SIGN_COST, COUNTED_COST, GROUP_COST = 6.0, 1.5, 2.5, -5.0, -6.0
"""Additional costs of naming a collectible other than the target, a building, a shop's sign, an ordinal, or a group."""

WINDOWS_COST, TOWARDS_COST = 2.0, 0.6
"""Further costs of naming a building by its windows, and of a walk towards a thing rather than to it."""

GROUP_OTHERWISE = 3.0
"""Additional cost of naming a group in a plan that does not prefer groups."""

AT_COST = 1.5
"""Additional cost of a turn at a thing: people name it as something to pass, or to walk to, more often."""

OFFSET_COSTS = {"at": 0.0, "before": 3.2, "after": 1.8}
"""Further costs of a turn at, before or after a thing: people say "at"."""

SIDE_SHARE = 0.11
"""Probability of stating the side on which something is passed."""

PAST_COST = 1.2
"""Additional cost of a walk past a thing: people rather name what they walk to."""

BETWEEN_COST = 1.3
"""Additional cost of a walk between two things."""

GAP_WIDTH = (1.5, 7.0)
"""Range of the distance between two landmarks to walk between, in units."""

NO_POST = ("building", "zebra_crossing", "shop_sign", "banner", "awning", "speed_sign")
"""Kinds excluded from "walk between": flat things, things on walls, and buildings."""

GROUP_LOOKAHEAD = 6
"""Places of the path after a waypoint within which the members of a group must be recognised."""

TURNS_BY_SEVERAL = ("at", "after")
"""Positions of a turn relative to a group; "before" would be ambiguous."""

BESIDE_WALL = 5.0
"""Maximum lateral distance of a building's wall from a walk past it, in units."""

CONFUSED_LOOKS = ("red", "brick")
"""Looks of buildings that people give one name: a house of red brick, and one painted red."""

UNNAMED_BUILDING = SegmentationLabel("building", look="grey")
"""Never named: nearly every building looks grey to some observers."""

PLACES = ("intersection", "junction", "corner")
"""Kinds of landmarks that are places, not things; `places` beside this file handles them."""


def landmark_options(route: DescribedRoute, waypoint: Waypoint) -> Iterator[StepOption]:
    """Yield candidate steps that refer to landmarks seen so far."""
    here = waypoint.pose.x, waypoint.pose.z
    seen = [landmark for landmark in route.landmarks if route.is_seen(landmark, waypoint)]
    alike: dict[str, list[Landmark]] = {}
    for landmark in seen:
        alike.setdefault(landmark.label.kind, []).append(landmark)
    named: list[tuple[Landmark, Thing, float]] = []
    for landmark in seen:
        distance = math.dist(here, (landmark.x, landmark.z))
        if landmark.label == UNNAMED_BUILDING or (waypoint.turned and waypoint.about == landmark.identity != ""):
            continue
        if landmark.label.kind in PLACES or landmark.label == route.target or not 2.0 <= distance <= MAX_STEP_LENGTH:
            continue
        off = turn_between(waypoint.pose.heading, bearing(here, (landmark.x, landmark.z)))
        words = turn_towards(off)
        if words is None or (words and waypoint.turned) or (words == ("around",) and waypoint.number > 0):
            continue
        if not path_turns_by(route, waypoint, words):
            continue
        after = replace(waypoint, pose=waypoint.pose.turned(sum(DEGREES[word] for word in words)))
        turns = tuple(Rotate(word) for word in words)
        name = _named(route, landmark, alike[landmark.label.kind], after)
        if name is not None:
            if not words:
                named.append((landmark, *name))
            make_options = _building_options if landmark.label.kind == "building" else _options
            yield from make_options(route, _Subject(landmark, name[0], turns, after, name[1]))
    yield from _walks_between(route, waypoint, named)
    yield from _walks_by_groups(route, waypoint)


def _named(
    route: DescribedRoute, landmark: Landmark, seen: list[Landmark], waypoint: Waypoint
) -> tuple[Thing, float] | None:
    """Return a name for a landmark and its cost; None if every name is ambiguous. `seen` are those of its kind."""
    if landmark.label.look in CONFUSED_LOOKS and any(_looks_confused(landmark, other) for other in seen):
        return None
    until = route.departures[min(waypoint.number + 12, route.last)]
    name = unique_name(landmark, route.of_kind(landmark.label.kind), waypoint.pose, until, route.random)
    kind = landmark.label.kind
    cost = (
        COLLECTIBLE_COST if kind in COLLECTIBLES else {"building": BUILDING_COST, "shop_sign": SIGN_COST}.get(kind, 0.0)
    )
    cost += WINDOWS_COST * (landmark.label.look == "arched")
    if name is not None:
        return name[0], cost + (0.0 if name[1] else AMBIGUITY_COST)
    if kind == "building":
        return None
    counted = counted_name(landmark, route.of_kind(landmark.label.kind), seen, waypoint.pose)
    return None if counted is None else (counted, cost + COUNTED_COST)


def _looks_confused(landmark: Landmark, other: Landmark) -> bool:
    """Return whether two buildings may be given one name although their looks differ."""
    return (
        other.label.kind == "building"
        and other.label.look in CONFUSED_LOOKS
        and other.label.look != landmark.label.look
    )


@dataclass(frozen=True, slots=True)
class _Subject:
    """A landmark that candidate steps refer to.

    Attributes:
        landmark: the landmark.
        name: its name.
        turns: initial turns that bring it into view.
        waypoint: the start of the walk, after these turns.
        cost: of using the name.
    """

    landmark: Landmark
    name: Thing
    turns: tuple[Step, ...]
    waypoint: Waypoint
    cost: float

    def option(self, route: DescribedRoute, step: Step, end: Pose, cost: float) -> Iterator[StepOption]:
        """Yield the candidate that ends with `step`, after the turns."""
        yield from route.option(self.waypoint, self.turns, step, end, self.cost + cost)


def _options(route: DescribedRoute, subject: _Subject) -> Iterator[StepOption]:
    """Yield candidate steps that refer to one thing."""
    pose, landmark, name = subject.waypoint.pose, subject.landmark, subject.name
    right, _ = pose.local(landmark.x, landmark.z)
    side = "right" if right > 0.0 else "left"
    passed = pose_after_passing(pose, landmark.x, landmark.z, PAST_DISTANCE)
    if _is_ahead(pose, passed):
        is_across = landmark.label.kind == "zebra_crossing"
        is_stated = route.random.random() < SIDE_SHARE * route.manner.directions
        stated_side = side if is_stated and abs(right) >= PLANNED_ASIDE and not is_across else ""
        yield from subject.option(route, Walk("past", (name,), stated_side), passed, PAST_COST)
    if PLANNED_ASIDE < abs(right) < 5.0 and landmark.label.kind != "zebra_crossing":
        beside = pose_after_passing(pose, landmark.x, landmark.z, 0.0)
        if _is_ahead(pose, beside):
            yield from subject.option(route, Walk("beside", (name,), side), beside, 3.0)
    for word, beyond in TURN_OFFSETS.items():
        yield from _turns(route, subject, word, pose_after_passing(pose, landmark.x, landmark.z, beyond))
    straight = Pose(pose.x, pose.z, bearing((pose.x, pose.z), (landmark.x, landmark.z)))
    distance = math.dist((pose.x, pose.z), (landmark.x, landmark.z))
    for way, near in REACHED_WITHIN.items():
        if distance - near > 2.0:
            cost = 1.0 + TOWARDS_COST * (way == "towards")
            yield from subject.option(route, Walk(way, (name,)), straight.ahead(distance - near), cost)


def _turns(route: DescribedRoute, subject: _Subject, word: str, end: Pose) -> Iterator[StepOption]:
    """Yield a turn at, before or after a thing, if the path turns there."""
    waypoint, landmark = subject.waypoint, subject.landmark
    number = route.nearest(end, waypoint.number)
    onward, at_once = route.onward_heading(number), route.onward_heading(number, 2)
    if onward is None or at_once is None or abs(turn_between(onward, at_once)) > MAX_BEND:
        return
    if not _is_ahead(waypoint.pose, end):
        return
    if (
        min(math.dist((landmark.x, landmark.z), place) for place in route.path[waypoint.number : number + 2])
        > PLANNED_AT
    ):
        return
    rotation = turn_between(end.heading, onward)
    direction = turn_word(rotation)
    inexact = abs(turn_between(DEGREES[direction], rotation))
    if abs(rotation) > 25.0 and direction != "around" and inexact < 45.0:
        cost = inexact / 20.0 + (-1.0 if abs(rotation) > 50.0 else 0.7) + AT_COST
        cost += OFFSET_COSTS[word]
        step = Rotate(direction, word, subject.name)
        yield from subject.option(route, step, end.turned(DEGREES[direction]), cost)


def _building_options(route: DescribedRoute, subject: _Subject) -> Iterator[StepOption]:
    """Yield a walk past a building along its wall, and towards one that is straight ahead."""
    pose, landmark, name = subject.waypoint.pose, subject.landmark, subject.name
    buildings = () if route.graph is None else route.graph.buildings
    building = next((building for building in buildings if building.identity == landmark.identity), None)
    if building is None:
        return
    corners = [pose.local(x, z) for x, z in building.corners]
    right, along = pose.local(landmark.x, landmark.z)
    nearest = min(corners, key=lambda corner: abs(corner[0]))
    is_aside = all(corner[0] > 0.5 for corner in corners) or all(corner[0] < -0.5 for corner in corners)
    if is_aside and abs(nearest[0]) < BESIDE_WALL and along > 1.0:
        side = "right" if nearest[0] > 0.0 else "left"
        far = max(ahead for across, ahead in corners if abs(across) < abs(nearest[0]) + 1.0)
        stated_side = side if route.random.random() < SIDE_SHARE * route.manner.directions else ""
        yield from subject.option(route, Walk("past", (name,), stated_side), pose.ahead(far + PAST_DISTANCE), PAST_COST)
    if abs(right) < 2.5 and along > REACHED_WITHIN["towards"] + 2.5:
        straight = Pose(pose.x, pose.z, bearing((pose.x, pose.z), (landmark.x, landmark.z)))
        end = straight.ahead(math.dist((pose.x, pose.z), (landmark.x, landmark.z)) - REACHED_WITHIN["towards"])
        yield from subject.option(route, Walk("towards", (name,)), end, 0.0)


def _walks_by_groups(route: DescribedRoute, waypoint: Waypoint) -> Iterator[StepOption]:
    """Yield candidate steps that refer to groups of landmarks, seen now or soon."""
    soon = replace(waypoint, number=min(waypoint.number + GROUP_LOOKAHEAD, route.last))
    until = route.departures[min(waypoint.number + 12, route.last)]
    seen = [
        landmark
        for landmark in route.landmarks
        if landmark.label.kind not in NEVER_SEVERAL and route.is_seen(landmark, soon)
    ]
    for landmark in seen:
        here = waypoint.pose.x, waypoint.pose.z
        off = turn_between(waypoint.pose.heading, bearing(here, (landmark.x, landmark.z)))
        words = turn_towards(off)
        if words is None or (words and (waypoint.turned or not route.is_seen(landmark, waypoint))):
            continue
        if (words == ("around",) and waypoint.number > 0) or not path_turns_by(route, waypoint, words):
            continue
        if not 2.0 <= math.dist(here, (landmark.x, landmark.z)) <= MAX_STEP_LENGTH:
            continue
        after = replace(waypoint, pose=waypoint.pose.turned(sum(DEGREES[word] for word in words)))
        group = group_nearest_to(landmark, route.of_kind(landmark.label.kind), seen, after.pose, until)
        if group is not None and not (waypoint.turned and waypoint.about == group.name.identity):
            yield from _group_options(route, group, tuple(Rotate(word) for word in words), after)


def _group_options(
    route: DescribedRoute, group: LandmarkGroup, turns: tuple[Step, ...], waypoint: Waypoint
) -> Iterator[StepOption]:
    """Yield walks past and to a group, and turns at it."""
    pose, landmarks = waypoint.pose, group.landmarks
    liking = GROUP_COST if route.prefers_groups else GROUP_OTHERWISE
    if any(math.dist((landmark.x, landmark.z), route.goal) < 0.1 for landmark in landmarks):
        return
    last = max(landmarks, key=lambda landmark: pose.local(landmark.x, landmark.z)[1])
    end = pose_after_passing(pose, last.x, last.z, PAST_DISTANCE)
    if _is_ahead(pose, end):
        rights = [pose.local(landmark.x, landmark.z)[0] for landmark in landmarks]
        side = "right" if min(rights) > PLANNED_ASIDE else "left" if max(rights) < -PLANNED_ASIDE else ""
        stated_side = side if route.random.random() < SIDE_SHARE * route.manner.directions else ""
        yield from route.option(waypoint, turns, Walk("past", (group.name,), stated_side), end, liking)
    x, z = (
        sum(landmark.x for landmark in landmarks) / len(landmarks),
        sum(landmark.z for landmark in landmarks) / len(landmarks),
    )
    straight = Pose(pose.x, pose.z, bearing((pose.x, pose.z), (x, z)))
    distance = math.dist((pose.x, pose.z), (x, z))
    for way, near in REACHED_WITHIN.items():
        if distance - near > 2.0:
            end = straight.ahead(distance - near)
            yield from route.option(waypoint, turns, Walk(way, (group.name,)), end, liking + 0.6)
    subject = _Subject(last, group.name, turns, waypoint, liking)
    for word in TURNS_BY_SEVERAL:
        beside = (x, z) if word == "at" else (last.x, last.z)
        yield from _turns(route, subject, word, pose_after_passing(pose, *beside, TURN_OFFSETS[word]))


def _walks_between(
    route: DescribedRoute, waypoint: Waypoint, named: list[tuple[Landmark, Thing, float]]
) -> Iterator[StepOption]:
    """Yield walks between two landmarks, whether their names are equal or not."""
    for (one, first, cost), (other, second, more) in combinations(named, 2):
        if first.kind in NO_POST or second.kind in NO_POST or first.which or second.which:
            continue
        if not _is_between(route, waypoint, one, other):
            continue
        if GAP_WIDTH[0] <= math.dist((one.x, one.z), (other.x, other.z)) <= GAP_WIDTH[1]:
            end = pose_after_passing(waypoint.pose, (one.x + other.x) / 2, (one.z + other.z) / 2, 0.3)
            yield from route.option(waypoint, (), Walk("between", (first, second)), end, cost + more + BETWEEN_COST)


def _is_between(route: DescribedRoute, waypoint: Waypoint, one: Landmark, other: Landmark) -> bool:
    """Return whether two landmarks stand on opposite sides of the path where it is nearest to them."""
    number = route.nearest(Pose((one.x + other.x) / 2, (one.z + other.z) / 2, 0.0), waypoint.number)
    before, after = route.path[max(number - 2, 0)], route.path[min(number + 2, route.last)]
    here = Pose(*route.path[number], bearing(before, after))
    (right, along), (more, far) = sorted(here.local(landmark.x, landmark.z) for landmark in (one, other))
    return right < -0.3 and more > 0.3 and abs(along - far) <= more - right


def _is_ahead(pose: Pose, end: Pose) -> bool:
    """Return whether a step's end is far enough ahead."""
    return math.dist((pose.x, pose.z), (end.x, end.z)) >= 1.5 and pose.local(end.x, end.z)[1] >= 0.0
