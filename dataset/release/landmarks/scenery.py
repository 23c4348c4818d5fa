"""Placement of recovered landmarks as a section's street furniture: on the ground, at corners and on walls."""

from collections.abc import Sequence

import numpy as np

from arramon_client.world import BANNER_SHAPES
from arramon_dataset.layout import furniture_colours
from arramon_dataset.layout.grid import to_street_frame, to_world_frame
from arramon_dataset.layout.prop_places import (
    AT_CORNERS,
    WALL_GAP,
    Surroundings,
    building_distance,
    corner_places,
    half_size,
    is_wall_clear,
    wall_places,
)
from arramon_dataset.release.landmarks.furniture_grid import FurnitureGrid, apart_from
from arramon_dataset.release.landmarks.own_furniture import front_towards_path
from arramon_dataset.release.landmarks.recovery import RecoveredLandmark
from arramon_dataset.release.landmarks.turn_paths import Numbers
from arramon_server.sim.assets import furniture
from arramon_server.sim.geometry import wrap
from arramon_server.sim.section import ON_WALLS, Building, Prop

TO_CORNER = 2.0
"""Maximum distance that a traffic light or a sign is moved to a corner, in units."""

TO_WALL = 6.0
"""Maximum distance that a banner is moved to a wall, in units."""

SPOKEN_AS = {"gold": "yellow", "silver": "white", "concrete": "white", "purple": "blue"}
"""By colour that texts state of banners: the nearest colour that banners have."""

SHAPE_COLOURS = {**furniture_colours.SHAPE_COLOURS, "orange": ("white",), "brown": ("red",)}


def props_of(
    landmarks: Sequence[RecoveredLandmark],
    heading: float,
    buildings: Sequence[Building],
    ground: FurnitureGrid,
    walked: Numbers,
) -> list[tuple[Prop, RecoveredLandmark]]:
    """Return recovered landmarks as props, those with the most votes first, without those that have no free place.

    Args:
        landmarks: of a section.
        heading: of its streets, degrees clockwise from +z.
        buildings: of the section.
        ground: between them.
        walked: (n, 2), positions on paths.
    """
    surroundings = Surroundings.of(heading, buildings, walked, np.zeros((0, 2)))
    built: list[tuple[Prop, RecoveredLandmark]] = []
    for landmark in sorted(landmarks, key=lambda each: (-each.votes, each.kind, each.x, each.z)):
        taken = [
            (prop.x, prop.z, prop.kind) for prop, _ in built if (prop.kind in ON_WALLS) == (landmark.kind in ON_WALLS)
        ]
        spot = (
            _on_wall(landmark, surroundings, taken)
            if landmark.kind == "banner"
            else _on_ground(landmark, surroundings, ground, walked, taken)
        )
        if spot is not None:
            x, z, facing = spot
            built.append((Prop(landmark.kind, x, z, facing, *look_of(landmark)), landmark))
    return built


def look_of(landmark: RecoveredLandmark) -> tuple[str, str, str]:
    """Return a prop's colour, shape and shape's colour: the nearest to those that texts state."""
    if landmark.kind == "banner":
        colour = SPOKEN_AS.get(landmark.colour, landmark.colour)
        colour = colour if colour in SHAPE_COLOURS else "blue"
        shape = landmark.look if landmark.look in BANNER_SHAPES else "star"
        return colour, shape, SHAPE_COLOURS[colour][0]
    possible = (*furniture.COLOURS.get(landmark.kind, ()), *furniture.IMPORTED_COLOURS.get(landmark.kind, ()))
    default = furniture.COLOURS.get(landmark.kind, ("",))[0]
    return landmark.colour if landmark.colour in possible else default, "", ""


def _on_ground(
    landmark: RecoveredLandmark,
    surroundings: Surroundings,
    ground: FurnitureGrid,
    walked: Numbers,
    taken: Sequence[tuple[float, float, str]],
) -> tuple[float, float, float] | None:
    place = np.array([landmark.x, landmark.z])
    if landmark.kind in AT_CORNERS:
        half_width, _ = half_size(landmark.kind)
        corners, fronts = corner_places(surroundings, half_width + WALL_GAP)
        places = to_world_frame(corners, surroundings.heading)
        clear = apart_from(places, landmark.kind, taken) & (building_distance(surroundings, corners) > 0.0)
        apart = np.where(clear, np.hypot(*(places - place).T), np.inf)
        if len(apart) and apart.min() <= TO_CORNER:
            at = int(apart.argmin())
            return round(float(places[at, 0]), 3), round(float(places[at, 1]), 3), _facing(fronts[at], surroundings)
    radius = furniture.footprint_radius(landmark.kind)
    free = np.flatnonzero((ground.clearance > radius) & apart_from(ground.places, landmark.kind, taken))
    if not len(free):
        return None
    spot = ground.places[free[int(np.hypot(*(ground.places[free] - place).T).argmin())]]
    return round(float(spot[0]), 3), round(float(spot[1]), 3), front_towards_path(spot, ground.heading, walked)


def _on_wall(
    landmark: RecoveredLandmark, surroundings: Surroundings, taken: Sequence[tuple[float, float, str]]
) -> tuple[float, float, float] | None:
    """Return the clear place on a wall that is nearest to a landmark, and the direction in which it faces."""
    half_width, _ = half_size("banner")
    places, fronts = wall_places(surroundings, 0.0, half_width)
    place = to_street_frame(np.array([[landmark.x, landmark.z]]), surroundings.heading)[0]
    near = np.flatnonzero(np.hypot(*(places - place).T) <= TO_WALL)
    places, fronts = places[near], fronts[near]
    clear = is_wall_clear(surroundings, places, fronts, half_width)
    world = to_world_frame(places, surroundings.heading)
    for x, z, _ in taken:
        clear &= np.hypot(world[:, 0] - x, world[:, 1] - z) >= 2.0 * half_width
    if not clear.any():
        return None
    at = int(np.where(clear, np.hypot(*(places - place).T), np.inf).argmin())
    return round(float(world[at, 0]), 3), round(float(world[at, 1]), 3), _facing(fronts[at], surroundings)


def _facing(direction: float, surroundings: Surroundings) -> float:
    return round(wrap(float(direction) + surroundings.heading), 3)
