"""Facts of a turn's ground truth for writers: legs, turns, passed landmarks, and the surroundings of the target.

They follow from the path and from what the camera shows along it, not from a plan of an instruction.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from arramon_client.world import turn_between
from arramon_dataset.generation.site import GenerationSite
from arramon_dataset.instructions.visible_landmarks import Landmark, find_landmarks, poses_along
from arramon_dataset.path_tolerances import FACTS_ASIDE, FACTS_BY, FACTS_DEVIATION, FACTS_NEAR, FACTS_SHORTEST_LEG
from arramon_dataset.paths import Place, direction, distance_from_line, offset_seen_from, simplify
from arramon_server.episodes.episode import Episode, Turn
from arramon_server.sim.geometry import Pose

IN_SIGHT = 14.0
"""Maximum distance of a landmark reported as straight ahead at the end of a leg, in units."""

PLACE_NAMES = {"t_junction": "T-junction", "street_end": "end of the street", "crossing": "crossing of streets"}


@dataclass(frozen=True, slots=True)
class PassedLandmark:
    """A landmark beside a leg.

    Attributes:
        name: in English, such as "white barrier".
        along: distance from the beginning of the leg, in units.
        aside: distance to the right of the leg, in units; negative on the left.
    """

    name: str
    along: float
    aside: float

    def __str__(self) -> str:
        if abs(self.aside) < FACTS_ASIDE:
            return f"{self.name} (at {self.along:.0f}, on the way)"
        return (
            f"{self.name} (at {self.along:.0f}, {abs(self.aside):.0f} to the {'right' if self.aside > 0 else 'left'})"
        )


@dataclass(frozen=True, slots=True)
class LegFacts:
    """A straight part of the path.

    Attributes:
        turn: degrees by which the agent turns before it, clockwise.
        length: in units.
        first: index of the pose with which it begins.
        passed: landmarks beside it, in order.
        ahead: names of landmarks straight ahead at its end, nearest first.
    """

    turn: float
    length: float
    first: int
    passed: tuple[PassedLandmark, ...]
    ahead: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class RouteFacts:
    """A turn's route.

    Attributes:
        poses: along the ground truth.
        landmarks: landmarks that are recognised along it.
        legs: in order.
        last_turn: degrees by which the agent turns at the end to face the target.
        around: landmarks around the target, with their positions as seen on arrival.
        others: the other objects of the turn that are seen along the path.
    """

    poses: tuple[Pose, ...]
    landmarks: tuple[Landmark, ...]
    legs: tuple[LegFacts, ...]
    last_turn: float
    around: tuple[str, ...]
    others: tuple[str, ...]


def route_facts(episode: Episode, number: int, site: GenerationSite) -> RouteFacts:
    """Return the facts of the navigation of turn 1 or 2 of an episode in a site."""
    turn = episode.turns[number - 1]
    start = episode.start
    if number == 2:
        before = episode.turns[0]
        start = poses_along(start, before.path, before.actions)[-1]
    poses = poses_along(start, turn.path, turn.actions)
    return facts_along(turn, poses, find_landmarks(poses, turn.street, site.section, site.landmark_camera, site.graph))


def facts_along(turn: Turn, poses: Sequence[Pose], landmarks: Sequence[Landmark]) -> RouteFacts:
    """Return the facts of a turn's navigation, from the poses of its ground truth and the landmarks along it."""
    landmarks = tuple(landmark for landmark in landmarks if landmark.seen)
    vertices = _vertices(turn.path)
    legs, heading = [], poses[0].heading
    for first, last in pairwise(vertices):
        (x0, z0), (x1, z1) = turn.path[first], turn.path[last]
        new = direction((x0, z0), (x1, z1))
        pose = Pose(x0, z0, new % 360.0)
        length = math.dist((x0, z0), (x1, z1))
        goal = (turn.target.position.x, turn.target.position.z)
        legs.append(
            LegFacts(
                turn_between(heading, new),
                length,
                next(n for n, p in enumerate(poses) if (p.x, p.z) == (x0, z0)),
                tuple(_passed(pose, length, landmarks, goal)),
                tuple(_ahead(pose.ahead(length), landmarks, goal)),
            )
        )
        heading = new
    goal_x, goal_z = turn.target.position.x, turn.target.position.z
    x, z = turn.path[-1]
    facing = direction((x, z), (goal_x, goal_z))
    return RouteFacts(
        tuple(poses),
        landmarks,
        tuple(legs),
        turn_between(heading, facing),
        tuple(_around(turn, poses, landmarks)),
        tuple(_others(turn, landmarks)),
    )


def landmark_name(landmark: Landmark) -> str:
    """Return a plain English name of a landmark."""
    label = landmark.label
    if label.kind == "junction":
        return PLACE_NAMES.get(label.look, label.look.replace("_", " "))
    if label.kind == "intersection":
        return f"opening of a street on the {label.look}"
    parts = (label.look.replace("_", " "), label.colour, label.kind.replace("_", " "))
    return " ".join(filter(None, parts))


def _vertices(path: Sequence[Place]) -> list[int]:
    """Return the indices of the ends and bends of a path, with short legs merged into the ones before."""
    kept = simplify(path, FACTS_DEVIATION, distance_from_line)
    found = [kept[0]]
    for index in kept[1:-1]:
        if (
            math.dist(path[found[-1]], path[index]) >= FACTS_SHORTEST_LEG
            and math.dist(path[index], path[-1]) >= FACTS_SHORTEST_LEG
        ):
            found.append(index)
    return [*found, kept[-1]]


def _passed(pose: Pose, length: float, landmarks: Sequence[Landmark], goal: Place) -> list[PassedLandmark]:
    found = []
    for landmark in landmarks:
        if math.dist((landmark.x, landmark.z), goal) < 0.1 or landmark.label.kind == "intersection":
            continue
        right, ahead = pose.local(landmark.x, landmark.z)
        if 0.5 <= ahead <= length + 0.5 and abs(right) <= FACTS_BY:
            found.append(PassedLandmark(landmark_name(landmark), ahead, right))
    return sorted(found, key=lambda each: each.along)


def _ahead(pose: Pose, landmarks: Sequence[Landmark], goal: Place) -> list[str]:
    found = []
    for landmark in landmarks:
        right, ahead = pose.local(landmark.x, landmark.z)
        is_ahead = 0.5 < ahead <= IN_SIGHT and abs(right) <= 0.25 * ahead + 0.5
        if (
            is_ahead
            and math.dist((landmark.x, landmark.z), goal) >= 0.1
            and landmark.label.kind not in ("intersection", "corner")
        ):
            found.append((ahead, f"{landmark_name(landmark)} ({ahead:.0f} farther on)"))
    return [name for _, name in sorted(found)[:4]]


def _around(turn: Turn, poses: Sequence[Pose], landmarks: Sequence[Landmark]) -> list[str]:
    x, z = turn.target.position.x, turn.target.position.z
    view = poses[max(len(poses) - 6, 0)]
    found = []
    for landmark in landmarks:
        right, ahead = offset_seen_from((view.x, view.z), (x, z), (landmark.x, landmark.z))
        distance = math.hypot(right, ahead)
        if 0.1 < distance <= FACTS_NEAR and landmark.label.kind != "intersection":
            place = [f"{abs(ahead):.1f} {'behind' if ahead > 0 else 'in front of'} it"] if abs(ahead) > 0.4 else []
            place += [f"{abs(right):.1f} to its {'right' if right > 0 else 'left'}"] if abs(right) > 0.4 else []
            found.append((distance, f"{landmark_name(landmark)}: {' and '.join(place) or 'at the same place'}"))
    return [line for _, line in sorted(found)[:6]]


def _others(turn: Turn, landmarks: Sequence[Landmark]) -> list[str]:
    target = (turn.target.position.x, turn.target.position.z)
    seen = {(landmark.x, landmark.z) for landmark in landmarks}
    return [
        str(item.type)
        for item in turn.street
        if (item.position.x, item.position.z) in seen and (item.position.x, item.position.z) != target
    ]
