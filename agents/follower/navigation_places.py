"""Where streets open to a side, seen on the agent's own map."""

import math

import numpy as np

from agents.follower.map import Map

OFFSETS = np.arange(-3.0, 14.0, 0.5)
"""Places along the walk that are looked at, in units from the agent."""

DEEP = 7.0
"""How far to the side the ground is looked at, in units."""

DEEPER = 2.5
"""By how much an opening is deeper than the street beside the wall before it, in units."""

WIDE = 3
"""Places in a row that make an opening."""

IN = 1.2
"""How far past the wall's end the turn is taken, in units: who is on the shortest way rounds corners closely."""


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
    start = first_opening(runs.tolist(), walls.tolist())
    if start is None:
        return None
    along = float(OFFSETS[start]) + IN
    return x + along * math.sin(angle), z + along * math.cos(angle)


def first_opening(runs: list[float], walls: list[bool]) -> int | None:
    """The first place of the first run of places that are clearly deeper than the wall before them."""
    beside: float | None = None
    for i, (run, wall) in enumerate(zip(runs, walls, strict=True)):
        if beside is not None and len(runs) - i >= WIDE and all(r >= beside + DEEPER for r in runs[i : i + WIDE]):
            return i
        if wall and run < DEEP - DEEPER:
            beside = run
    return None
