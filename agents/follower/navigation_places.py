"""Where streets open to a side, seen on the agent's own map."""

import math

import numpy as np

from agents.follower.map import Map
from lang.going import DEEP, DEEPER, IN

OFFSETS = np.arange(-3.0, 14.0, 0.5)
"""Places along the walk that are looked at, in units from the agent."""

SEEN = 1.0
"""By how much deeper it must have been seen to be, in units."""

WIDE = 3
"""Places that make an opening."""


def opening(ground: Map, x: float, z: float, angle: float, side: int) -> tuple[float, float] | None:
    """Where to turn into the next street that opens to one side; None where none is known yet.

    Args:
        ground: the agent's map.
        x, z, angle: the walk, `angle` in radians.
        side: 1 for the right, -1 for the left.

    Returns:
        (x, z) on the line of the walk.
    """
    runs, walls = ground.runs(x, z, angle, side, OFFSETS, DEEP)
    for start in all_openings(runs.tolist(), walls.tolist()):
        along = float(OFFSETS[start]) + IN
        if along > 0.0:
            return x + along * math.sin(angle), z + along * math.cos(angle)
    return None


def all_openings(runs: list[float], walls: list[bool]) -> list[int]:
    """The first places after walls that clearly deeper places follow, as far as these can be seen.

    Who comes along a street sees of one that opens to the side a part first, behind the corner: its first places count
    as open even though they are not seen yet, and its depth as far as it is known.
    """
    found: list[int] = []
    beside, last, open_places = 0.0, None, 0
    for i, (run, wall) in enumerate(zip(runs, walls, strict=True)):
        if wall and run < DEEP - DEEPER and (last is None or run < beside + DEEPER):
            beside, last, open_places = run, i, 0
        elif last is not None and run >= beside + SEEN:
            open_places += 1
            if open_places == WIDE:
                found.append(last + 1)
                last = None
    return found
