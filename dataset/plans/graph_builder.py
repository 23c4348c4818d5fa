"""Construction of a section's street graph from its plan and its buildings."""

import math

from arramon_dataset.plans.graph import STRAIGHT, Arm, Corner, Junction, Road, StreetGraph, angle_between
from arramon_dataset.plans.junction_detection import (
    SHARPEST_CURVE,
    DetectedJunction,
    MiddleLine,
    Mouth,
    detect_junctions,
    middle_lines_of,
)
from arramon_dataset.plans.named_buildings import corners_of, named_building
from arramon_dataset.plans.plan import Plan
from arramon_server.sim.section import Building, Section

WIDEST_ALLEY = 3.0
"""Width of the widest alley, in units."""

LARGEST_CORNER, FARTHEST_CORNER = 150.0, 8.0
"""Maximum angle between two neighbouring arms with a block's corner between them, in degrees, and maximum distance of
the corner from the junction, in units."""

AT_CORNER = 1.5
"""Maximum distance between a building's corner and the corner of its block, in units: facades are set back."""


def street_graph(plan: Plan, section: Section) -> StreetGraph:
    """Return the graph of a section that was built from this plan; the same input gives the same graph."""
    lines = middle_lines_of(plan)
    detections = [detected for detected in detect_junctions(plan, lines) if _kind(detected, lines)]
    numbered = {id(detected): f"junction/{number}" for number, detected in enumerate(detections)}
    junctions = tuple(_junction(detected, detections, numbered, lines) for detected in detections)
    roads = tuple(_road(plan, line, detections, numbered) for line in lines)
    buildings = tuple(named_building(number, section, roads, lines) for number in range(len(section.buildings)))
    return StreetGraph(junctions, roads, _corners(junctions, roads, section.buildings), buildings)


def _road_identity(number: int) -> str:
    return f"street/{number}"


def _junction(
    detected: DetectedJunction,
    detections: list[DetectedJunction],
    numbered: dict[int, str],
    lines: tuple[MiddleLine, ...],
) -> Junction:
    arms = []
    for mouth in detected.mouths:
        line = lines[mouth.line]
        x, z = line.places[mouth.at].round(3).tolist()
        leads_to = _next(mouth, line, detected, detections, numbered)
        arms.append(Arm(line.heading(mouth.at, mouth.direction), _road_identity(mouth.line), leads_to, x, z))
    arms.sort(key=lambda arm: arm.heading)
    centre_x, centre_z = _middle(detected)
    radius = max(math.dist((centre_x, centre_z), (arm.x, arm.z)) for arm in arms)
    kind = _kind(detected, lines)
    return Junction(numbered[id(detected)], centre_x, centre_z, kind, tuple(arms), round(radius, 3))


def _middle(detected: DetectedJunction) -> tuple[float, float]:
    """Return the mean of a meeting's nodes, or of its square's corners."""
    places = detected.nodes if detected.corners is None else detected.corners
    x, z = places.mean(axis=0).round(3).tolist()
    return x, z


def _kind(detected: DetectedJunction, lines: tuple[MiddleLine, ...]) -> str:
    """Return one of `graph.JUNCTIONS`; "" for a meeting that is no junction but a continuing road."""
    headings = [lines[mouth.line].heading(mouth.at, mouth.direction) for mouth in detected.mouths]
    if not headings:
        return ""
    if detected.corners is not None:
        return "square"
    if len(headings) == 1:
        return "street_end"
    if len(headings) == 2:
        return "bend" if 180.0 - angle_between(*headings) > SHARPEST_CURVE else ""
    if len(headings) > 3:
        return "crossing"
    in_line = any(
        180.0 - angle_between(one, other) < STRAIGHT for i, one in enumerate(headings) for other in headings[i + 1 :]
    )
    return "t_junction" if in_line else "fork"


def _next(
    mouth: Mouth,
    line: MiddleLine,
    detected: DetectedJunction,
    detections: list[DetectedJunction],
    numbered: dict[int, str],
) -> str:
    """Return the identity of the next junction along a road that leaves a junction; "" if there is none."""
    others = [m for m in detections if m is not detected and line.number in m.grounds]
    for at in line.following(mouth.at, mouth.direction):
        for other in others:
            if other.grounds[line.number][at]:
                return numbered[id(other)]
    return ""


def _road(plan: Plan, line: MiddleLine, detections: list[DetectedJunction], numbered: dict[int, str]) -> Road:
    street = plan.streets[line.number]
    passed = sorted(
        (int(m.grounds[line.number].argmax()), numbered[id(m)])
        for m in detections
        if line.number in m.grounds and m.grounds[line.number].any()
    )
    points = tuple((round(x, 3), round(z, 3)) for x, z in plan.lines()[line.number].tolist())
    kind = "alley" if street.width <= WIDEST_ALLEY else "street"
    return Road(_road_identity(line.number), street.name, kind, street.width, points, tuple(name for _, name in passed))


def _corners(
    junctions: tuple[Junction, ...], roads: tuple[Road, ...], buildings: tuple[Building, ...]
) -> tuple[Corner, ...]:
    """Return the corners of the blocks at all junctions but squares, clockwise at each."""
    widths = {road.identity: road.width for road in roads}
    found: list[Corner] = []
    for junction in junctions:
        around = junction.arms if len(junction.arms) > 1 and junction.kind != "square" else ()
        for arm, following in zip(around, around[1:] + around[:1], strict=True):
            if not 0.0 < (following.heading - arm.heading) % 360.0 < LARGEST_CORNER:
                continue
            place = _meet(_edge(arm, widths[arm.road] / 2), _edge(following, -widths[following.road] / 2))
            corner = _corner_near(place, buildings)
            if corner is not None and math.dist(place, (junction.x, junction.z)) <= FARTHEST_CORNER:
                found.append(Corner(f"corner/{len(found)}", *corner, junction.identity))
    return tuple(found)


def _edge(arm: Arm, aside: float) -> tuple[float, float, float, float]:
    """Return the line along an arm, `aside` units to the right of its middle: (x, z) and its direction."""
    angle = math.radians(arm.heading)
    sin, cos = math.sin(angle), math.cos(angle)
    return arm.x + aside * cos, arm.z - aside * sin, sin, cos


def _meet(one: tuple[float, float, float, float], other: tuple[float, float, float, float]) -> tuple[float, float]:
    """Return where two lines that are not parallel meet."""
    x, z, sin, cos = one
    x1, z1, sin1, cos1 = other
    far = ((x1 - x) * cos1 - (z1 - z) * sin1) / (sin * cos1 - cos * sin1)
    return x + far * sin, z + far * cos


def _corner_near(place: tuple[float, float], buildings: tuple[Building, ...]) -> tuple[float, float, str] | None:
    """Return the building's corner nearest to where a block's edges meet, and its building; None if none is near."""
    found = [
        (round(math.dist(corner, place), 6), *corner, f"building/{number}")
        for number, building in enumerate(buildings)
        for corner in corners_of(building)
    ]
    distance, x, z, building = min(found, default=(math.inf, 0.0, 0.0, ""))
    return (x, z, building) if distance <= AT_CORNER else None
