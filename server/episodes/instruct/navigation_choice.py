"""Which landmark a name would be taken for by someone on the way, and by what name one is to be called.

The order is that of the follower (agents/follower/map_landmarks.py): the server cannot import it, nor it the server.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from random import Random

from lang.meaning import Thing
from server.episodes.instruct.navigation_legs import Leg
from server.episodes.instruct.sight import Landmark
from server.sim.catalogue import KINDS
from server.sim.furniture import COLOURS

BEHIND = -1.5
"""What is farther behind than this is not meant, in units."""

OFF_AXIS = 1.5
"""How much a thing off the direction of the walk counts as farther away, for each squared radian."""

CLEARLY = 1.35
"""How many times farther away every other thing of the name must count."""


@dataclass(frozen=True, slots=True)
class Named:
    """A landmark that can be spoken of, where it is as the leg goes.

    Attributes:
        thing: its name.
        mark: the landmark.
        right: units to the right of the leg.
        along: units along the leg from its start.
    """

    thing: Thing
    mark: Landmark
    right: float
    along: float


def nameable(
    marks: Sequence[Landmark],
    leg: Leg,
    since: int,
    until: int,
    random: Random,
    *,
    start: float = 0.0,
    off: float = 0.0,
) -> list[Named]:
    """The furniture that can be named without doubt on a leg.

    Args:
        marks: all that is seen on the way.
        leg: the leg.
        since: the number of the pose from which the landmark is looked for.
        until: the number of the last pose at which it may first come into view.
        random: draws whether colours are said where they need not be.
        start: how far along the leg it is looked for from, in units.
        off: by how many degrees clockwise the way that one faces there is off the leg's.
    """
    found = []
    for mark in marks:
        if mark.label.kind in KINDS or mark.seen[0] > until:
            continue
        right, along = leg.local(mark.x, mark.z)
        if along < start - 1.0:
            continue
        names = [Thing(mark.label.kind, mark.label.colour, mark.label.look)]
        if mark.label.kind in COLOURS and random.random() < 0.4:
            names.insert(0, Thing(mark.label.kind))
        for name in names:
            if is_meant(name, mark, marks, leg, since, until, start, off):
                found.append(Named(name, mark, right, along))
                break
    return found


def is_meant(
    name: Thing, mark: Landmark, marks: Sequence[Landmark], leg: Leg, since: int, until: int, start: float, off: float
) -> bool:
    """Whether one who looks for the name from `start` units along the leg takes the mark for it, and no other."""
    own = _counts(mark, leg, start, off)
    for other in marks:
        if other is mark or not fits(name, other) or other.seen[0] > until:
            continue
        counts = _counts(other, leg, start, off)
        if counts < math.inf and (counts < CLEARLY * own or other.seen[0] < mark.seen[0] > since):
            return False
    return own < math.inf


def fits(name: Thing, mark: Landmark) -> bool:
    """Whether a name is one of the landmark's, as far as it goes."""
    label = mark.label
    return name.kind == label.kind and name.colour in ("", label.colour) and name.look in ("", label.look)


def _counts(mark: Landmark, leg: Leg, start: float, turned: float) -> float:
    """As how far away it counts; infinite where it is behind."""
    right, along = leg.local(mark.x, mark.z)
    along -= start
    sin, cos = math.sin(math.radians(turned)), math.cos(math.radians(turned))
    right, along = right * cos - along * sin, right * sin + along * cos
    if along < BEHIND:
        return math.inf
    off = math.atan2(right, along)
    return math.hypot(right, along) * (1.0 + OFF_AXIS * off * off)
