"""Dashed centre lines of the streets, which are detected between the buildings."""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from arramon_server.sim.section import Building, Section

_CELL = 0.5
_BEYOND = 6.0
"""Distance beyond the bounds within which streets are detected, in units."""

NARROWEST, WIDEST = 3.0, 11.0
"""Range of the width of a road with a line, between its pavements, in units."""

SHORTEST = 5.0
"""A stretch of road shorter than this gets no line, in units."""

DRIFT = 1.0
"""Largest shift of a road's middle along its length, as facades are set back by different amounts, in units."""

DASH, GAP = 1.0, 1.0
"""Length of a dash and of the gap after it, in units."""


CLEAR = 2.0
"""Least distance between the middles of two dashes at an oblique angle, in units."""


class Dash(NamedTuple):
    """A dash's middle (x, z) and its direction, degrees clockwise from +z."""

    x: float
    z: float
    heading: float


def dashes(section: Section, pavement: float) -> list[Dash]:
    """Return the dashes of all roads of a section, along and across its main heading and the buildings' headings.

    Args:
        section: the section; its streets run along its buildings.
        pavement: width of the pavement around each building, in units.
    """
    x0, z0, x1, z1 = section.bounds
    middle = ((x0 + x1) / 2, (z0 + z1) / 2)
    reach = math.hypot(x1 - x0, z1 - z0) / 2 + _BEYOND
    offsets = np.arange(-reach, reach, _CELL)
    roads: list[list[Dash]] = []
    for heading in headings(section):
        angle = math.radians(heading)
        sin, cos = math.sin(angle), math.cos(angle)
        # A row of the raster is across the road; rows follow each other along it.
        along, across = np.meshgrid(offsets, offsets, indexing="ij")
        x, z = middle[0] + across * cos + along * sin, middle[1] - across * sin + along * cos
        road = np.ones(x.shape, bool)
        for building in section.buildings:
            road &= ~covers(building, x, z, pavement)
        for start, end, centre in _stretches(road):
            roads.append([])
            for k in range(int((end - start) // (DASH + GAP))):
                forward = offsets[0] + start + k * (DASH + GAP) + (DASH + GAP) / 2
                aside = offsets[0] + centre
                place = (middle[0] + aside * cos + forward * sin, middle[1] - aside * sin + forward * cos)
                roads[-1].append(Dash(float(place[0]), float(place[1]), heading))
    return _apart(roads)


def _apart(roads: list[list[Dash]]) -> list[Dash]:
    """Remove dashes that cross those of a longer road, as a road may be detected for several headings.

    Roads at right angles may cross.
    """
    kept: dict[int, list[Dash]] = {}
    for number in sorted(range(len(roads)), key=lambda number: -len(roads[number])):
        before = [dash for dashes in kept.values() for dash in dashes]
        kept[number] = [dash for dash in roads[number] if not any(_clash(dash, other) for other in before)]
    return [dash for number in sorted(kept) for dash in kept[number]]


def _clash(one: Dash, other: Dash) -> bool:
    slanting = 1.0 < (one.heading - other.heading) % 90.0 < 89.0
    return slanting and math.hypot(one.x - other.x, one.z - other.z) < CLEAR


def headings(section: Section) -> list[float]:
    """Return the headings of streets: the section's, those of its buildings, and those at right angles to them."""
    turned = {round((building.heading - section.heading) % 90.0, 6) % 90.0 for building in section.buildings}
    return [section.heading + angle + across for angle in sorted({0.0, *turned}) for across in (0.0, 90.0)]


def covers(
    building: Building, x: npt.NDArray[np.float64], z: npt.NDArray[np.float64], margin: float
) -> npt.NDArray[np.bool_]:
    """Return whether points (x, z) are in a building, or nearer to its sides than `margin`."""
    angle = math.radians(building.heading)
    sin, cos = math.sin(angle), math.cos(angle)
    right = (x - building.x) * cos - (z - building.z) * sin
    ahead = (x - building.x) * sin + (z - building.z) * cos
    covered: npt.NDArray[np.bool_] = (np.abs(right) < building.half_width + margin) & (
        np.abs(ahead) < building.half_length + margin
    )
    return covered


def _stretches(road: npt.NDArray[np.bool_]) -> Iterator[tuple[float, float, float]]:
    """Yield (from, to, centre) of straight roads along the first axis of a raster, in units from its corner."""
    running: list[tuple[int, list[float]]] = []  # the row where a road began, and its centre in every row since
    for row in range(len(road) + 1):
        centres = _centres(road[row]) if row < len(road) else []
        going_on = []
        for begun, before in running:
            near = [centre for centre in centres if abs(centre - before[0]) <= DRIFT]
            if near:
                centres.remove(near[0])
                going_on.append((begun, [*before, near[0]]))
            elif len(before) * _CELL >= SHORTEST:
                yield begun * _CELL, row * _CELL, float(np.median(before))
        running = going_on + [(row, [centre]) for centre in centres]


def _centres(row: npt.NDArray[np.bool_]) -> list[float]:
    """Return the centres of a row's intervals between two buildings that have the width of a road."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], row, [False]]).astype(np.int8)))
    starts, ends = edges[::2], edges[1::2]
    widths = (ends - starts) * _CELL
    roads = (widths >= NARROWEST) & (widths <= WIDEST) & (starts > 0) & (ends < len(row))
    return [float(centre) for centre in (starts + ends - 1)[roads] * _CELL / 2]
