"""Several things that are named together, "both benches" or "the cones": which stand together, and what they are."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from lang.meaning import Thing
from lang.street import GROUP
from server.dataset.instructions.navigation_choice import fits, perceived_distance
from server.dataset.instructions.sight import Landmark
from server.sim.geometry import Pose

SEPARATE = 4.0
"""Minimum distance of any other thing of the same name from a group's farthest one, in units."""


@dataclass(frozen=True, slots=True)
class Group:
    """Things that are named together.

    Attributes:
        name: of number "two" or "several", with the identities of all.
        marks: the landmarks, the nearest first.
    """

    name: Thing
    marks: tuple[Landmark, ...]


def group_of(mark: Landmark, marks: Sequence[Landmark], seen: Sequence[Landmark], view: Pose) -> Group | None:
    """Return the group whose nearest member a landmark is, or None if it stands alone or is not clearly apart.

    Args:
        mark: a landmark.
        marks: all landmarks.
        seen: those that have been seen by now.
        view: position and course of the walker.
    """
    for name in dict.fromkeys((Thing(mark.label.kind), Thing(mark.label.kind, mark.label.colour, mark.label.look))):
        fitting = [other for other in marks if fits(name, other)]
        members = [other for other in fitting if _apart(mark, other) <= GROUP - 0.5]
        if len(members) < 2 or any(other not in seen for other in members):
            continue
        own = perceived_distance(mark, view)
        if any(perceived_distance(other, view) < own for other in members):
            continue
        rest = [other for other in fitting if other not in members]
        if any(_apart(mark, other) < GROUP + SEPARATE or perceived_distance(other, view) < 2.0 * own for other in rest):
            continue
        members.sort(key=lambda other: (_apart(mark, other), other.identity))
        number = "two" if len(members) == 2 else "several"
        identity = "+".join(sorted(other.identity for other in members))
        return Group(Thing(name.kind, name.colour, name.look, number=number, identity=identity), tuple(members))
    return None


def _apart(one: Landmark, other: Landmark) -> float:
    return math.dist((one.x, one.z), (other.x, other.z))
