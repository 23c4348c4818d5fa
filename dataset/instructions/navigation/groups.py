"""Groups of similar landmarks with one plural name, such as "both benches" or "the cones"."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from arramon_client.world import COLLECTIBLES
from arramon_dataset.instructions.navigation.landmark_names import name_matches, perceived_distance
from arramon_dataset.instructions.visible_landmarks import Landmark
from arramon_lang.meaning import Thing
from arramon_lang.street_words import GROUP_RADIUS
from arramon_server.sim.geometry import Pose

SEPARATE = 4.0
"""Minimum distance of any other thing of the same name from a group, beyond the group's own extent, in units."""

CLEARLY_FARTHER = 1.35
"""Minimum ratio of the perceived distances of any other thing of the same name and of a group's nearest."""

NEVER_SEVERAL = (*COLLECTIBLES, "building", "intersection", "junction", "corner")
"""Kinds that never get a plural name."""


@dataclass(frozen=True, slots=True)
class LandmarkGroup:
    """Landmarks that share one plural name.

    Attributes:
        name: of number "two" or "several", with the identities of all.
        landmarks: the landmarks, the nearest first.
    """

    name: Thing
    landmarks: tuple[Landmark, ...]


def groups_centred_on(
    landmark: Landmark, landmarks: Sequence[Landmark], seen: Sequence[Landmark], until: int
) -> Iterator[LandmarkGroup]:
    """Yield the groups centred on a landmark, those with the shorter name first.

    Args:
        landmark: a landmark.
        landmarks: all landmarks of its kind.
        seen: the landmarks recognised where the group is named; only these can be members.
        until: index of the last pose; landmarks glimpsed later cannot be confused with the members.
    """
    if landmark.label.kind in NEVER_SEVERAL:
        return
    for name in dict.fromkeys(
        (Thing(landmark.label.kind), Thing(landmark.label.kind, landmark.label.colour, landmark.label.look))
    ):
        fitting = [other for other in landmarks if name_matches(name, other)]
        members = [other for other in fitting if _apart(landmark, other) <= GROUP_RADIUS - 0.5]
        if len(members) < 2 or any(other not in seen for other in members):
            continue
        rest = (other for other in fitting if other not in members and _is_glimpsed(other, until))
        if any(_apart(landmark, other) < GROUP_RADIUS + SEPARATE for other in rest):
            continue
        members.sort(key=lambda other: (_apart(landmark, other), other.identity))
        number = "two" if len(members) == 2 else "several"
        identity = "+".join(sorted(other.identity for other in members))
        yield LandmarkGroup(Thing(name.kind, name.colour, name.look, number=number, identity=identity), tuple(members))


def group_nearest_to(
    landmark: Landmark, landmarks: Sequence[Landmark], seen: Sequence[Landmark], view: Pose, until: int
) -> LandmarkGroup | None:
    """Return the group whose nearest member is the landmark; None if there is none or it is not clearly separate.

    Args:
        landmark: a landmark.
        landmarks: all landmarks of its kind.
        seen: the landmarks recognised within the next few places.
        view: position and course of the walker.
        until: index of the last pose; landmarks glimpsed later cannot be confused with the members.
    """
    own = perceived_distance(landmark, view)
    for group in groups_centred_on(landmark, landmarks, seen, until):
        rest = (
            o for o in landmarks if name_matches(group.name, o) and o not in group.landmarks and _is_glimpsed(o, until)
        )
        if any(perceived_distance(other, view) < own for other in group.landmarks):
            continue
        if all(perceived_distance(other, view) >= CLEARLY_FARTHER * own for other in rest):
            return group
    return None


def _is_glimpsed(landmark: Landmark, until: int) -> bool:
    return landmark.glimpsed is not None and landmark.glimpsed <= until


def _apart(one: Landmark, other: Landmark) -> float:
    return math.dist((one.x, one.z), (other.x, other.z))
