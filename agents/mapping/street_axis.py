"""Direction of the streets on the agent's own map."""

import math

import numpy as np
import numpy.typing as npt

from arramon_agents.mapping.ground_map import CELL, GroundMap

MIN_WALLS = 30
"""Minimum number of cells with walls for the direction of streets to be read from them."""


def street_axis(ground: GroundMap) -> int:
    """Return the direction of the streets: in which of three the walls on the map lie on the fewest lines.

    Returns:
        Multiples of 30 degrees clockwise from the agent's first heading, 0, 1 or 2: streets cross at right angles, and
        agents start at a multiple of 30 degrees from them. 0 if few walls have been seen.
    """
    places = np.argwhere(ground.layers()[2]) * CELL
    if len(places) < MIN_WALLS:
        return 0
    return max(range(3), key=lambda axis: _sharpness(places, math.radians(30.0 * axis)))


def _sharpness(places: npt.NDArray[np.floating], angle: float) -> float:
    """Return how much places gather on lines in the direction `angle` (radians) and at right angles to it."""
    sin, cos = math.sin(angle), math.cos(angle)
    total = 0.0
    for offsets in (places[:, 0] * cos - places[:, 1] * sin, places[:, 0] * sin + places[:, 1] * cos):
        lines = np.bincount(np.floor((offsets - offsets.min()) / CELL).astype(np.int64))
        total += float((lines.astype(np.float64) ** 2).sum())
    return total
