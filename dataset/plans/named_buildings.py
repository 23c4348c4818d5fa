"""The attributes by which instructions can name a building: colour, facade, size and shop sign."""

import math

import numpy as np

from arramon_dataset.layout.grid import Points
from arramon_dataset.layout.solids import distance_from_rectangle
from arramon_dataset.plans.graph import NamedBuilding, Road
from arramon_dataset.plans.junction_detection import MiddleLine
from arramon_server.sim.section import Building, Section

COLOURS = {
    "brick": ("red", "brown"), "brown": ("brown",), "concrete": ("grey", "white"), "glass": ("blue", "grey"),
    "white": ("white",), "arched": ("yellow", "brown"), "red": ("red",), "grey": ("grey",),
    "yellow": ("yellow",), "green": ("green",), "blue": ("blue",),
}  # fmt: skip
"""Colour names that fit each facade, the likeliest first."""

AT_ROAD = 0.8
"""Maximum distance between a building and the edge of a road for the building to count as on that road, in units."""

ON_WALL = 0.05
"""Maximum distance of a sign from the wall of its building, in units."""

TALL = 6.5
"""Minimum height of a building called tall, in units: about seven storeys."""

SMALL, SMALL_GROUND = 2.6, 30.0
"""Maximum height and ground area of a building called small, in units and square units: two storeys."""


def named_building(
    number: int, section: Section, roads: tuple[Road, ...], lines: tuple[MiddleLine, ...]
) -> NamedBuilding:
    """Return a building of a section with the attributes by which it can be named.

    Args:
        number: index of the building in the section.
        section: the section.
        roads: of the section's plan.
        lines: middle lines of the roads, in the same order.
    """
    building = section.buildings[number]
    at = tuple(
        road.identity
        for road, line in zip(roads, lines, strict=True)
        if distance_from_building(building, line.places).min() <= road.width / 2 + AT_ROAD
    )
    return NamedBuilding(
        f"building/{number}",
        building.x,
        building.z,
        corners_of(building),
        COLOURS[building.facade],
        building.facade,
        size_of(building),
        _sign_of(building, section),
        at,
    )


def _sign_of(building: Building, section: Section) -> str:
    """Return the kind of shop named by the sign on a building's wall; "" without a sign."""
    signs = [prop for prop in section.props if prop.kind == "shop_sign"]
    places = np.array([(sign.x, sign.z) for sign in signs]).reshape(-1, 2)
    on = np.flatnonzero(distance_from_building(building, places) < ON_WALL)
    return signs[int(on[0])].shape if len(on) else ""


def size_of(building: Building) -> str:
    """Return "tall", "small" or "", for a building that is neither."""
    if building.height >= TALL:
        return "tall"
    small = building.height <= SMALL and 4 * building.half_width * building.half_length <= SMALL_GROUND
    return "small" if small else ""


def corners_of(building: Building) -> tuple[tuple[float, float], ...]:
    """Return the (x, z) of a building's four corners, clockwise."""
    angle = math.radians(building.heading)
    sin, cos = math.sin(angle), math.cos(angle)
    return tuple(
        (
            round(building.x + across * building.half_width * cos + along * building.half_length * sin, 3),
            round(building.z - across * building.half_width * sin + along * building.half_length * cos, 3),
        )
        for across, along in ((1, 1), (1, -1), (-1, -1), (-1, 1))
    )


def distance_from_building(building: Building, places: Points) -> Points:
    """Return the distance of places (n, 2) of (x, z) from a building, in units, (n,); 0 inside."""
    half = np.array([building.half_width, building.half_length])
    distance: Points = distance_from_rectangle(
        places, np.array([building.x, building.z]), half, building.heading
    ).round(6)
    return distance
