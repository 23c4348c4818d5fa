"""Several things that are named together, "both benches" or "the cones": which stand together, and what they are."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from arramon_client.world import COLLECTIBLES
from arramon_dataset.instructions.navigation.choice import fits, perceived_distance
from arramon_dataset.instructions.sight import Landmark
from arramon_lang.meaning import Thing
from arramon_lang.street import GROUP_RADIUS
from arramon_server.sim.geometry import Pose

SEPARATE = 4.0
"""Minimum distance of any other thing of the same name from a group, beyond the group's own extent, in units."""

CLEARLY_FARTHER = 1.35
"""Minimum ratio of the perceived distances of any other thing of the same name and of a group's nearest."""

NEVER_SEVERAL = (*COLLECTIBLES, "building", "intersection", "junction", "corner")
"""Kinds of which several are not named together."""


@dataclass(frozen=True, slots=True)
class Group:
    """Things that are named together.

    Attributes:
        name: of number "two" or "several", with the identities of all.
        marks: the landmarks, the nearest first.
    """

    name: Thing
    marks: tuple[Landmark, ...]


def groups_around(mark: Landmark, marks: Sequence[Landmark], seen: Sequence[Landmark], until: int) -> Iterator[Group]:
    """Yield the groups of which a landmark is the middle, those with the shorter name first.

    Args:
        mark: a landmark.
        marks: all landmarks of its kind.
        seen: those that are recognised where they are named: all that may be in a group.
        until: index of the last pose; what is glimpsed later cannot be taken for one of them.
    """
    if mark.label.kind in NEVER_SEVERAL:
        return
    for name in dict.fromkeys((Thing(mark.label.kind), Thing(mark.label.kind, mark.label.colour, mark.label.look))):
        fitting = [other for other in marks if fits(name, other)]
        members = [other for other in fitting if _apart(mark, other) <= GROUP_RADIUS - 0.5]
        if len(members) < 2 or any(other not in seen for other in members):
            continue
        rest = (other for other in fitting if other not in members and _is_glimpsed(other, until))
        if any(_apart(mark, other) < GROUP_RADIUS + SEPARATE for other in rest):
            continue
        members.sort(key=lambda other: (_apart(mark, other), other.identity))
        number = "two" if len(members) == 2 else "several"
        identity = "+".join(sorted(other.identity for other in members))
        yield Group(Thing(name.kind, name.colour, name.look, number=number, identity=identity), tuple(members))


def group_of(
    mark: Landmark, marks: Sequence[Landmark], seen: Sequence[Landmark], view: Pose, until: int
) -> Group | None:
    """Return the group whose nearest member a landmark is, or None if it stands alone or is not clearly apart.

    Args:
        mark: a landmark.
        marks: all landmarks of its kind.
        seen: those that are recognised as one walks on.
        view: position and course of the walker.
        until: index of the last pose; what is glimpsed later cannot be taken for one of them.
    """
    own = perceived_distance(mark, view)
    for group in groups_around(mark, marks, seen, until):
        rest = (o for o in marks if fits(group.name, o) and o not in group.marks and _is_glimpsed(o, until))
        if any(perceived_distance(other, view) < own for other in group.marks):
            continue
        if all(perceived_distance(other, view) >= CLEARLY_FARTHER * own for other in rest):
            return group
    return None


def _is_glimpsed(mark: Landmark, until: int) -> bool:
    return mark.glimpsed is not None and mark.glimpsed <= until


def _apart(one: Landmark, other: Landmark) -> float:
    return math.dist((one.x, one.z), (other.x, other.z))
