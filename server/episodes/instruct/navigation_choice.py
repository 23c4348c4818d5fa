"""Which landmark a name would be taken for by someone on the way, and by what name one is to be called.

The order is that of the follower (agents/follower/map_landmarks.py): the server cannot import it, nor it the server.
"""

import math
from collections.abc import Sequence
from random import Random

from lang.going import OFF_AXIS
from lang.meaning import Thing
from server.episodes.instruct.sight import Landmark
from server.sim.furniture import COLOURS
from server.sim.geometry import Pose

BEHIND = -1.5
"""What is farther behind than this is not meant, in units."""

CLEARLY = 1.35
"""How many times farther away every other thing of the name must count."""

SHORTER = 0.4
"""How often a colour is left out where it need not be said."""


def name_of(
    mark: Landmark, marks: Sequence[Landmark], view: Pose, until: int, random: Random
) -> tuple[Thing, bool] | None:
    """A name by which the landmark, and nothing else that is seen, is meant; None where there is none.

    Args:
        mark: seen by now.
        marks: all that there is.
        view: where one stands who looks for it, and the course.
        until: the number of the last pose from which things are seen that may be mistaken for it.
        random: draws whether a colour is said where it need not be.

    Returns:
        The name, and whether it could be mistaken for nothing even if all could be seen.
    """
    label = mark.label
    names = [Thing(label.kind, label.colour, label.look)]
    if label.kind in COLOURS and random.random() < SHORTER:
        names.insert(0, Thing(label.kind))
    own = counts(mark, view)
    for name in names if own < math.inf else []:
        rivals = [m for m in marks if m is not mark and fits(name, m) and counts(m, view) < CLEARLY * own]
        if not any(rival.glimpsed is not None and rival.glimpsed <= until for rival in rivals):
            return name, not rivals
    return None


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
