"""Streets that open on the sides of a path, detected as the follower does in agents/follower/side_streets.py."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from arramon_dataset.paths import Leg, Place, legs_of
from arramon_lang.street_words import OPENING_DEPTH, OPENING_INSET, OPENING_RANGE
from arramon_server.sim.section import Building, Section

WIDE = 3.0
"""Minimum width of an opening, in units: well above the follower's threshold."""

GRAIN = 0.5
"""Spacing of the sampled ground, in units."""


@dataclass(frozen=True, slots=True)
class Opening:
    """A street that opens to one side of a leg.

    Attributes:
        side: "left" or "right".
        x, z: where to turn into it, on the leg or beyond its end.
        first, last: indices of the leg's ends in the path.
    """

    side: str
    x: float
    z: float
    first: int
    last: int


def openings(path: Sequence[Place], section: Section) -> tuple[Opening, ...]:
    """Return all openings along a path, leg by leg, in order."""
    found = []
    for leg in legs_of(path):
        for side, sign in (("left", -1), ("right", 1)):
            for along in _openings(leg, sign, section.buildings):
                angle = math.radians(leg.heading)
                x, z = leg.start[0] + along * math.sin(angle), leg.start[1] + along * math.cos(angle)
                found.append(Opening(side, x, z, leg.first, leg.last))
    return tuple(found)


def _openings(leg: Leg, sign: int, buildings: Sequence[Building]) -> list[float]:
    """Return the distances along a leg at which streets open to one side."""
    alongs = np.arange(-3.0, leg.length + WIDE + 2.0, GRAIN)
    aside = np.arange(0.0, OPENING_RANGE, GRAIN)
    angle = math.radians(leg.heading)
    x = leg.start[0] + alongs[:, None] * math.sin(angle) + sign * aside[None, :] * math.cos(angle)
    z = leg.start[1] + alongs[:, None] * math.cos(angle) - sign * aside[None, :] * math.sin(angle)
    built = _built(x, z, buildings)
    built[:, -1] = True
    runs = built.argmax(axis=1) * GRAIN
    found, last = [], None
    for i, run in enumerate(runs.tolist()):
        if run < OPENING_RANGE - OPENING_DEPTH:
            last = i
        elif last is not None and (runs[last + 1 : last + 1 + round(WIDE / GRAIN)] >= runs[last] + OPENING_DEPTH).all():
            found.append(float(alongs[last]) + GRAIN + OPENING_INSET)
            last = None
    return [along for along in found if 1.0 < along < leg.length + 1.5]


def _built(
    x: npt.NDArray[np.float64], z: npt.NDArray[np.float64], buildings: Sequence[Building]
) -> npt.NDArray[np.bool_]:
    """Return which of the points are in a building."""
    built = np.zeros(x.shape, dtype=bool)
    middle, reach = (float(x.mean()), float(z.mean())), math.hypot(np.ptp(x), np.ptp(z)) / 2
    for building in buildings:
        if math.dist(middle, (building.x, building.z)) > reach + building.half_width + building.half_length:
            continue
        angle = math.radians(building.heading)
        dx, dz, sin, cos = x - building.x, z - building.z, math.sin(angle), math.cos(angle)
        inside = np.abs(dx * cos - dz * sin) < building.half_width
        inside &= np.abs(dx * sin + dz * cos) < building.half_length
        built |= inside
    return built
