"""Map of a section from above with an episode's paths, as coordinates for SVG."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from arramon_server.episodes.provenance import AGREEMENT, COLOUR, DRAWN, TEXT, PropOrigin
from arramon_server.scoring.trajectory import Point2, TurnRecord
from arramon_server.sim.section import Building, Section

MARGIN = 6.0
"""Border of the map around the reachable ground, in units."""


@dataclass(frozen=True, slots=True)
class SectionMap:
    """Map of a section, with x to the right and z upwards.

    Attributes:
        width, height: size of the map, in units.
        roofs: corners of each building, in SVG's notation.
        props: positions of randomly drawn street furniture.
        agreed: position and number of votes of each recovered landmark.
        from_text: positions of furniture derived from the episode's own text.
    """

    width: float
    height: float
    roofs: tuple[str, ...]
    props: tuple[tuple[float, float], ...]
    agreed: tuple[tuple[float, float, int], ...] = ()
    from_text: tuple[tuple[float, float], ...] = ()


@dataclass(frozen=True, slots=True)
class TurnPaths:
    """One turn's paths on a section.

    Attributes:
        truth: the reference path, in SVG's notation.
        played: the path played; empty if the turn was not begun.
        start: start of the path played, or of the reference path if the turn was not begun.
        target: position of the target.
        end: end of the path played; None if the turn was not begun.
        forced: whether a limit, not the agent, picked an object up.
        ways: the points of both paths on the map; of the second none if the turn was not begun.
    """

    truth: str
    played: str
    start: tuple[float, float]
    target: tuple[float, float]
    end: tuple[float, float] | None
    forced: bool
    ways: tuple[tuple[Point2, ...], tuple[Point2, ...]]


def draw_section(section: Section, origins: Sequence[PropOrigin] = ()) -> SectionMap:
    """Return the map of a section.

    Args:
        section: the section, with all furniture to show.
        origins: origin of each of its props; empty if all were drawn.
    """
    x0, z0, x1, z1 = section.bounds
    named = list(zip(section.props, origins or [PropOrigin(DRAWN)] * len(section.props), strict=True))
    placed = [(place_on_map(section, (prop.x, prop.z)), origin) for prop, origin in named]
    return SectionMap(
        round(x1 - x0 + 2 * MARGIN, 1),
        round(z1 - z0 + 2 * MARGIN, 1),
        tuple(polyline(section, _corners(building)) for building in section.buildings),
        tuple(place for place, origin in placed if origin.name == DRAWN),
        tuple((*place, round(origin.votes)) for place, origin in placed if origin.name == AGREEMENT),
        tuple(place for place, origin in placed if origin.name in (COLOUR, TEXT)),
    )


def turn_paths(section: Section, record: TurnRecord) -> TurnPaths:
    """Return a turn's paths on the map of its section."""
    path = record.path
    return TurnPaths(
        polyline(section, record.reference_path),
        polyline(section, path),
        place_on_map(section, path[0] if path else record.reference_path[0]),
        place_on_map(section, (record.target_position[0], record.target_position[2])),
        place_on_map(section, path[-1]) if path else None,
        record.pickup_forced,
        (points_on_map(section, record.reference_path), points_on_map(section, path)),
    )


def place_on_map(section: Section, point: Point2) -> tuple[float, float]:
    """Return a place (x, z) of a section on its map."""
    x0, _, _, z1 = section.bounds
    return round(point[0] - x0 + MARGIN, 2), round(z1 - point[1] + MARGIN, 2)


def polyline(section: Section, points: Sequence[Point2]) -> str:
    """Return places of a section on its map, in SVG's notation."""
    return " ".join(f"{x:g},{y:g}" for x, y in points_on_map(section, points))


def points_on_map(section: Section, points: Sequence[Point2]) -> tuple[Point2, ...]:
    """Return places of a section on its map."""
    return tuple(place_on_map(section, point) for point in points)


def _corners(building: Building) -> list[Point2]:
    angle = math.radians(building.heading)
    sin, cos = math.sin(angle), math.cos(angle)
    ends = ((-1, -1), (1, -1), (1, 1), (-1, 1))
    extents = [(a * building.half_width, b * building.half_length) for a, b in ends]
    return [(building.x + u * cos + v * sin, building.z - u * sin + v * cos) for u, v in extents]
