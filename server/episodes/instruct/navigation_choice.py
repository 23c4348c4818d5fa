"""Which landmark a name would be taken for by someone on the way, and by what name one is to be called.

The order is that of the follower (agents/follower/map_landmarks.py): the server cannot import it, nor it the server.
"""

import math
from collections.abc import Sequence
from random import Random

from lang.meaning import Thing
from server.episodes.instruct.sight import Landmark
from server.sim.furniture import COLOURS
from server.sim.geometry import Pose

BEHIND = -1.5
"""What is farther behind than this is not meant, in units."""

OFF_AXIS = 1.5
"""How much a thing off the course counts as farther away, for each squared radian."""

CLEARLY = 1.35
"""How many times farther away every other thing of the name must count."""

SHORTER = 0.4
"""How often a colour is left out where it need not be said."""


def name_of(mark: Landmark, marks: Sequence[Landmark], view: Pose, until: int, random: Random) -> Thing | None:
    """A name by which the landmark, and no other, is meant; None where there is none.

    Args:
        mark: seen by now.
        marks: all that is seen on the way.
        view: where one stands who looks for it, and the course.
        until: the number of the last pose from which things are seen that may be mistaken for it.
        random: draws whether a colour is said where it need not be.
    """
    label = mark.label
    names = [Thing(label.kind, label.colour, label.look)]
    if label.kind in COLOURS and random.random() < SHORTER:
        names.insert(0, Thing(label.kind))
    return next((name for name in names if is_meant(name, mark, marks, view, until)), None)


def is_meant(name: Thing, mark: Landmark, marks: Sequence[Landmark], view: Pose, until: int) -> bool:
    """Whether one who looks for the name takes the mark for it, and no other; arguments as of `name_of`."""
    own = counts(mark, view)
    return own < math.inf and not any(
        other is not mark and other.seen[0] <= until and fits(name, other) and counts(other, view) < CLEARLY * own
        for other in marks
    )


def fits(name: Thing, mark: Landmark) -> bool:
    """Whether a name is one of the landmark's, as far as it goes."""
    label = mark.label
    return name.kind == label.kind and name.colour in ("", label.colour) and name.look in ("", label.look)


def counts(mark: Landmark, view: Pose) -> float:
    """As how far away it counts, in units; infinite where it is behind."""
    right, along = view.local(mark.x, mark.z)
    if along < BEHIND:
        return math.inf
    off = math.atan2(right, along)
    return math.hypot(right, along) * (1.0 + OFF_AXIS * off * off)
