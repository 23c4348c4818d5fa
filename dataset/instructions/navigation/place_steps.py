"""Candidate steps that refer to places: crossings, corners, side streets, and the end of the street."""

import math
from collections.abc import Iterator
from dataclasses import replace

from arramon_client.world import turn_between
from arramon_dataset.instructions.navigation.route import (
    DescribedRoute,
    StepOption,
    Waypoint,
    path_turns_by,
    turn_word,
)
from arramon_dataset.instructions.visible_landmarks import Landmark
from arramon_dataset.path_tolerances import PLANNED_DEVIATION
from arramon_dataset.plans.graph import Junction, StreetGraph
from arramon_lang.meaning import Rotate, Step, Thing, Walk
from arramon_lang.street_words import CROSSED_DISTANCE, DEGREES
from arramon_server.sim.geometry import Pose

MAX_BEND = 25.0
"""Maximum angle between the path's next steps and its later direction once a turn is complete, in degrees."""

NAMES: dict[str, tuple[tuple[str, int], ...]] = {
    "crossing": (("intersection", 18), ("corner", 3), ("street", 7)),
    "t_junction": (("t_junction", 6), ("intersection", 4), ("street_end", 1), ("corner", 2)),
    "side street": (("intersection", 10), ("street", 12), ("corner", 3)),
    "alley": (("alley", 3), ("corner", 1)),
    "bend": (("corner", 4), ("street_end", 1)),
    "fork": (("intersection", 4), ("corner", 1), ("street", 1)),
    "square": (("square", 2), ("corner", 1)),
    "": (("corner", 1),),
}
"""Names for a place, with weights, by its appearance to the walker."""

CROSSED = ("crossing", "left_turn", "right_turn", "fork")
"""Kinds of junctions, as the walker sees them, that people cross and call intersections."""

ORDINALS = ("", "second", "third")

FIRST_SHARE = 0.7
"""Probability that the first street on a side is called so: "the first street on the left"."""

UNCLEAR_ALONE = ("corner", "street")
"""Names without a landmark or an ordinal that leave open which place is meant, where several come."""

OTHERS_WITHIN = 8.0
"""Maximum distance of another place from one, along the course, at which the walker may take it for that one."""

NAMES_DRAWN = 3
"""Names drawn for one place, since the check of the plan may reject some of them."""

PLACE_COST = -6.0
"""Additional cost of a turn at a place; negative because people prefer streets and corners to other landmarks."""

COUNTED_COST = -5.0
"""Additional cost of a counted street, such as "the second street on the left"."""

WALK_COST = -1.0
"""Additional cost of a walk to a place, or across it."""

SIDE_STREET_COST = 3.0
"""The same where a street opens on one side only."""

NEAR_CORNER = 4.5
"""Maximum distance of a building's corner from a turn that it marks, in units."""

BUILDING_SHARE = 0.25
"""Probability that a corner is named after its building where possible."""


def place_options(route: DescribedRoute, waypoint: Waypoint) -> Iterator[StepOption]:
    """Yield turns into streets ahead, and walks to and across places, possibly after an initial turn."""
    yield from _options(route, waypoint, ())
    onward = route.onward_heading(waypoint.number)
    if waypoint.number == 0 and onward is not None:
        word = turn_word(turn_between(waypoint.pose.heading, onward))
        if path_turns_by(route, waypoint, (word,)):
            after = replace(waypoint, pose=waypoint.pose.turned(DEGREES[word]))
            yield from _options(route, after, (Rotate(word),))


def _options(route: DescribedRoute, waypoint: Waypoint, turns: tuple[Step, ...]) -> Iterator[StepOption]:
    openings = _openings_ahead(route, waypoint)
    for side, degrees in (("left", -90.0), ("right", 90.0)):
        own = [(along, landmark) for along, landmark in openings if landmark.label.look == side]
        for number, (along, landmark) in enumerate(own[: len(ORDINALS)]):
            if number and own[0][0] < 1.5:
                continue  # Whether the first opening counts would be ambiguous.
            yield from _turn_into(route, waypoint, turns, openings, number, (along, landmark), degrees)
    yield from _walks(route, waypoint, turns, openings)


def _openings_ahead(route: DescribedRoute, waypoint: Waypoint) -> list[tuple[float, Landmark]]:
    """Return the openings along the course, each with its distance, in order."""
    found = []
    for landmark in route.landmarks:
        if landmark.label.kind == "intersection":
            right, along = waypoint.pose.local(landmark.x, landmark.z)
            if along > -1.0 and abs(right) < PLANNED_DEVIATION:
                found.append((along, landmark))
    return sorted(found, key=lambda item: (item[0], item[1].label.look))


def _turn_into(
    route: DescribedRoute,
    waypoint: Waypoint,
    turns: tuple[Step, ...],
    openings: list[tuple[float, Landmark]],
    number: int,
    place: tuple[float, Landmark],
    degrees: float,
) -> Iterator[StepOption]:
    along, landmark = place
    pose = waypoint.pose
    end = pose.ahead(along)
    at = route.nearest(end, waypoint.number)
    onward, at_once = route.onward_heading(at), route.onward_heading(at, 2)
    if landmark.seen[0] > route.departures[waypoint.number] or along < 1.5 or onward is None or at_once is None:
        return
    inexact = abs(turn_between(pose.heading + degrees, onward))
    if inexact >= 40.0 or abs(turn_between(onward, at_once)) >= 2.0 * MAX_BEND:
        return
    names = (_name(route, openings, number, place, pose) for _ in range(NAMES_DRAWN))
    for thing in dict.fromkeys(name for name in names if name is not None):
        cost = inexact / 20.0 + PLACE_COST + (COUNTED_COST if number else 0.0)
        yield from route.option(waypoint, turns, Rotate(landmark.label.look, "at", thing), end.turned(degrees), cost)


def _name(
    route: DescribedRoute,
    openings: list[tuple[float, Landmark]],
    number: int,
    place: tuple[float, Landmark],
    pose: Pose,
) -> Thing | None:
    """Return a name for a side street or for the place where it opens, or None."""
    along, landmark = place
    junction = junction_of(route.graph, landmark)
    if junction is None:
        return Thing("corner", identity=landmark.identity) if number == 0 else None
    if number:
        return _counted_name(route, openings, number, place, pose, junction)
    corner = _building_corner(route, junction, landmark, pose.ahead(along))
    if corner is not None and route.random.random() < BUILDING_SHARE:
        return corner
    is_first = route.random.random() < FIRST_SHARE
    several = any(abs(far - along) > 2.0 and far < along + OTHERS_WITHIN for far, _ in openings)
    names = [
        (kind, weight)
        for kind, weight in NAMES[apparent_kind(route.graph, junction, landmark, pose.heading)]
        if not (several and kind in UNCLEAR_ALONE and not (kind == "street" and is_first))
    ]
    names = names or list(NAMES[apparent_kind(route.graph, junction, landmark, pose.heading)])
    kinds, weights = zip(*names, strict=True)
    (kind,) = route.random.choices(kinds, weights)
    if kind in ("street", "alley"):
        identity = opening_identity(junction, landmark, pose.heading, kind)
        return Thing(kind, which="first" if is_first and kind == "street" else "", identity=identity)
    return _place(kind, junction)


def _counted_name(
    route: DescribedRoute,
    openings: list[tuple[float, Landmark]],
    number: int,
    place: tuple[float, Landmark],
    pose: Pose,
    junction: Junction,
) -> Thing | None:
    """Return a name with an ordinal among the similar streets on one side, or None if they differ in kind."""
    along, landmark = place
    before = [other for far, other in openings if far < along + 0.1]
    same_side = [other for other in before if other.label.look == landmark.label.look]
    roads = {road_kind(route.graph, junction_of(route.graph, other), other, pose.heading) for other in same_side}
    if len(roads) == 1 and "" not in roads:
        kind = roads.pop()
        return Thing(kind, which=ORDINALS[number], identity=opening_identity(junction, landmark, pose.heading, kind))
    return None


def apparent_kind(graph: StreetGraph | None, junction: Junction, landmark: Landmark, heading: float) -> str:
    """Return the key of NAMES for an opening, as seen by a walker who arrives with this heading."""
    if road_kind(graph, junction, landmark, heading) == "alley":
        return "alley"
    kind = junction.kind_from(heading)
    if junction.kind == "bend":
        return "bend"
    if kind in ("left_turn", "right_turn"):
        return "side street"
    return kind if kind in NAMES else ""


def junction_of(graph: StreetGraph | None, landmark: Landmark) -> Junction | None:
    """Return the junction of an opening; None if it is unknown."""
    return (
        graph.junction(landmark.identity) if graph is not None and landmark.identity.startswith("junction/") else None
    )


def road_kind(graph: StreetGraph | None, junction: Junction | None, landmark: Landmark, heading: float) -> str:
    """Return the kind of road behind an opening, "street" or "alley"; "" if it is unknown."""
    arm = (
        None if junction is None else junction.arm_towards(heading + (-90.0 if landmark.label.look == "left" else 90.0))
    )
    return "" if arm is None or graph is None else graph.road(arm.road).kind


def opening_identity(junction: Junction, landmark: Landmark, heading: float, kind: str) -> str:
    """Return the identity at an opening: of the street for "street" and "alley", otherwise of the junction."""
    if kind in ("street", "alley"):
        arm = junction.arm_towards(heading + (-90.0 if landmark.label.look == "left" else 90.0))
        if arm is not None:
            return arm.road
    return junction.identity


def _building_corner(route: DescribedRoute, junction: Junction, landmark: Landmark, at: Pose) -> Thing | None:
    """Return the near corner of a side street, named after its building; None if another building looks alike."""
    assert route.graph is not None
    side = -1.0 if landmark.label.look == "left" else 1.0
    near = []
    for corner in route.graph.corners:
        right, ahead = at.local(corner.x, corner.z)
        if corner.junction == junction.identity and right * side > 0.0 and math.hypot(right, ahead) < NEAR_CORNER:
            near.append((ahead, corner))
    if not near:
        return None
    _, corner = min(near, key=lambda item: (item[0], item[1].identity))
    building = next((m for m in route.landmarks if m.identity == corner.building), None)
    if building is None or not building.seen:
        return None
    alike = [
        m
        for m in route.landmarks
        if m.label == building.label and m is not building and math.dist((m.x, m.z), (at.x, at.z)) < 15.0
    ]
    if alike or building.label.look == "grey":
        return None
    return Thing("building_corner", look=building.label.look, identity=corner.identity)


def _walks(
    route: DescribedRoute, waypoint: Waypoint, turns: tuple[Step, ...], openings: list[tuple[float, Landmark]]
) -> Iterator[StepOption]:
    """Yield walks to the next crossing or to the end of the street, and across the next crossing."""
    ahead = [(along, landmark) for along, landmark in openings if along >= 1.5]
    if not ahead or len(ahead) < len(openings) or ahead[0][1].seen[0] > route.departures[waypoint.number]:
        return
    along, landmark = ahead[0]
    junction = junction_of(route.graph, landmark)
    if junction is None or along < 3.0:
        return
    pose = waypoint.pose
    kind = junction.kind_from(pose.heading)
    is_crossed = kind in CROSSED and len(junction.arms) >= 3
    cost = PLACE_COST + (WALK_COST if kind in ("crossing", "t_junction") else SIDE_STREET_COST)
    if is_crossed or kind == "t_junction":
        name = "intersection" if is_crossed else route.random.choice(("t_junction", "t_junction", "street_end"))
        step = Walk("to", (_place(name, junction),))
        yield from route.option(waypoint, turns, step, pose.ahead(along), cost)
    if is_crossed:
        step = Walk("past", (_place("intersection", junction),))
        yield from route.option(waypoint, turns, step, pose.ahead(along + CROSSED_DISTANCE), cost)


def _place(kind: str, junction: Junction) -> Thing:
    """Return a junction as a thing of this kind, with its number of arms."""
    return Thing(kind, identity=junction.identity, arms=len(junction.arms))
