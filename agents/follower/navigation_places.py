"""Detection of side streets on the agent's own map."""

import math

import numpy as np

from agents.follower.map import Map
from lang.street import DEEP, DEEPER, IN

OFFSETS = np.arange(-3.0, 14.0, 0.5)
"""Places along the walk that are examined, in units from the agent."""

SEEN = 1.0
"""Minimum additional depth of an opening compared with the walls before it, in units."""

WIDE = 3
"""Minimum number of consecutive places of an opening."""


def find_opening(ground: Map, x: float, z: float, angle: float, side: int) -> tuple[float, float] | None:
    """Return the place to turn into the next side street; None if none is known yet.

    Args:
        ground: the agent's map.
        x, z, angle: position and direction of the walk, `angle` in radians.
        side: 1 for the right, -1 for the left.

    Returns:
        (x, z) on the line of the walk.
    """
    runs, walls = ground.runs(x, z, angle, side, OFFSETS, DEEP)
    for start in find_openings(runs.tolist(), walls.tolist()):
        along = float(OFFSETS[start]) + IN
        if along > 0.0:
            return x + along * math.sin(angle), z + along * math.cos(angle)
    return None


def find_openings(runs: list[float], walls: list[bool]) -> list[int]:
    """Return the index of the first place of each opening: after a wall, and followed by clearly deeper places.

    From a street, only a part of a side street is visible at first, behind the corner: the opening therefore starts
    right after the wall, even if its first places have not been seen, and its depth counts as far as it is known.
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
