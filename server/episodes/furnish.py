"""Puts street furniture and banners into a section: along facades and at corners, in nobody's way.

How often each kind stands in the streets follows how often the instructions of the original benchmark name it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache
from random import Random

import numpy as np
from scipy.spatial import cKDTree

from server.episodes.chance import seeded
from server.episodes.grid import Mask, Points, turn, turn_back
from server.sim import furniture
from server.sim.furniture import footprint_radius
from server.sim.geometry import AGENT_RADIUS, wrap
from server.sim.section import Building, Prop

PATH_GAP = AGENT_RADIUS + 0.1
"""Units that stay free between what stands on the ground and every path."""

TARGET_GAP = 0.4
"""Units that stay free between what stands on the ground and every target."""

COUNTS = {
    "dumpster": 6, "phone_booth": 7, "bench": 8, "barrier": 6, "tree": 5, "tyre_stack": 2, "bags": 2, "mailbox": 3,
    "bin": 5, "barrel": 6, "traffic_light": 5, "stop_sign": 2, "speed_sign": 2, "lamp_post": 9, "hydrant": 4,
    "cone": 14, "banner": 10,
}  # fmt: skip
"""How many of each kind a section gets where there is room, the bulky ones first."""

AT_CORNERS = frozenset({"traffic_light", "stop_sign", "speed_sign"})
IN_THE_OPEN = frozenset({"cone", "barrel", "barrier", "hydrant"})

COLOURS = {
    **furniture.COLOURS,
    "cone": ("orange", "orange", "red", "blue"),
    "banner": ("red", "blue", "green", "yellow", "white", "black"),
}
"""What each kind is drawn from: the likelier ones more than once."""

SHAPES = ("star", "star", "diamond", "diamond", "triangle", "hexagon", "circle", "dot")
SHAPE_COLOURS = {
    "red": ("white", "yellow", "black"), "blue": ("white", "yellow", "red"), "green": ("white", "yellow", "red"),
    "yellow": ("red", "blue", "black"), "white": ("red", "blue", "green"), "black": ("white", "yellow", "red"),
}  # fmt: skip
"""Of a banner, by its ground colour."""

WALL_GAP = 0.06
"""Between a thing and the wall behind it, in units."""

TRIED = 500
"""Places tried for each kind."""

REACH = 2.5
"""Nothing stands farther than this from every path, in units: nobody would see it."""


@dataclass
class Plan:
    """What furniture has to keep clear of, in the section's turned frame (see `grid`), and what stands already.

    Attributes:
        heading: of the streets.
        low, high: (n, 2) opposite corners of the buildings, as (across, along).
        trodden: points along all paths.
        targets: of all episodes; None without any.
    """

    heading: float
    low: Points
    high: Points
    trodden: cKDTree
    targets: cKDTree | None
    placed: list[Prop] = field(default_factory=list)
    spots: list[tuple[float, float, float]] = field(default_factory=list)  # across, along, radius


def furnish(
    section_id: str, heading: float, buildings: Sequence[Building], trodden: Points, targets: Points
) -> tuple[Prop, ...]:
    """The section's furniture; the same input gives the same.

    Args:
        section_id: draws what stands where.
        heading: of the streets and of all buildings, degrees clockwise from +z.
        buildings: of the section.
        trodden: (n, 2) of (x, z): points close together along every path.
        targets: (m, 2) of (x, z).
    """
    centres = turn(np.array([[b.x, b.z] for b in buildings]).reshape(-1, 2), heading)
    halves = np.array([[b.half_width, b.half_length] for b in buildings]).reshape(-1, 2)
    plan = Plan(
        heading,
        centres - halves,
        centres + halves,
        cKDTree(turn(trodden, heading)),
        cKDTree(turn(targets, heading)) if len(targets) else None,
    )
    random = seeded(section_id, "furniture")
    for kind, count in COUNTS.items():
        places, fronts = candidates(plan, kind, random)
        for _ in range(count):
            place(plan, kind, places, fronts, random)
    return tuple(plan.placed)


def candidates(plan: Plan, kind: str, random: Random) -> tuple[Points, Points]:
    """Some places for a thing of this kind, as far as ground, paths and targets go: (n, 2) places, (n,) fronts.

    A front is in degrees clockwise from the turned frame's `along` axis.
    """
    half_width, half_length = extents(kind)
    if kind == "banner":
        places, fronts = beside_walls(plan, 0.0, half_width)
        clear = hangs_free(plan, places, fronts, half_width) & (plan.trodden.query(places)[0] < REACH)
        places, fronts = some(places[clear], fronts[clear], random)
        clear = in_view(plan, places + 0.1 * ahead(fronts))
        return places[clear], fronts[clear]
    if kind in AT_CORNERS:
        places, fronts = at_corners(plan, half_width + WALL_GAP)
    elif kind in IN_THE_OPEN:
        places, fronts = in_the_open(plan)
    else:
        places, fronts = beside_walls(plan, half_length + WALL_GAP, half_width)
    radius = footprint_radius(kind)
    distance, _ = plan.trodden.query(places)
    clear = (distance >= PATH_GAP + radius + 0.01) & (distance < REACH)
    sideways = (fronts % 180.0 == 90.0)[:, None]
    clear &= outside(plan, places, np.where(sideways, (half_length, half_width), (half_width, half_length))) > 0.0
    if plan.targets is not None:
        clear &= plan.targets.query(places)[0] >= TARGET_GAP + radius
    places, fronts = some(places[clear], fronts[clear], random)
    clear = in_view(plan, places)
    return places[clear], fronts[clear]


def some(places: Points, fronts: Points, random: Random) -> tuple[Points, Points]:
    """At most TRIED of the places, with their fronts."""
    kept = random.sample(range(len(places)), min(TRIED, len(places)))
    return places[kept], fronts[kept]


@cache
def extents(kind: str) -> tuple[float, float]:
    """Half of what a thing of this kind takes up across and along its front, in units, whatever its colour."""
    meshes = [furniture.piece_of(kind, colour).mesh for colour in furniture.COLOURS.get(kind, ("",))]
    halves = np.max([np.abs(mesh.vertices[:, :2]).max(axis=0) for mesh in meshes], axis=0)
    return float(halves[0]), float(halves[1])


def ahead(fronts: Points) -> Points:
    """(n, 2): the unit vectors that the fronts (n,) point along."""
    angles = np.radians(fronts)
    return np.stack([np.sin(angles), np.cos(angles)], axis=1)


def hangs_free(plan: Plan, places: Points, fronts: Points, half_width: float) -> Mask:
    """(n,): whether half a unit in front of the whole stretch of wall there is no other building."""
    outwards = ahead(fronts)
    aside = outwards[:, ::-1] * np.array([1.0, -1.0])
    clear = np.ones(len(places), dtype=bool)
    for offset in (-half_width, 0.0, half_width):
        clear &= outside(plan, places + 0.5 * outwards + offset * aside) > 0.0
    return clear


def beside_walls(plan: Plan, back: float, margin: float) -> tuple[Points, Points]:
    """Places every half unit along all facades, `back` units in front of them, `margin` units from their ends."""
    places: list[tuple[float, float, float]] = []
    for (left, near), (right, far) in zip(plan.low, plan.high, strict=True):
        for across in np.arange(left + margin, right - margin, 0.5):
            places += [(across, near - back, 180.0), (across, far + back, 0.0)]
        for along in np.arange(near + margin, far - margin, 0.5):
            places += [(left - back, along, 270.0), (right + back, along, 90.0)]
    table = np.array(places).reshape(-1, 3)
    return table[:, :2], table[:, 2]


def at_corners(plan: Plan, back: float) -> tuple[Points, Points]:
    """Places off the corners of buildings, facing along one of the two streets."""
    places: list[tuple[float, float, float]] = []
    for (left, near), (right, far) in zip(plan.low, plan.high, strict=True):
        places += [(left - back, near - back, front) for front in (180.0, 270.0)]
        places += [(right + back, near - back, front) for front in (90.0, 180.0)]
        places += [(left - back, far + back, front) for front in (0.0, 270.0)]
        places += [(right + back, far + back, front) for front in (0.0, 90.0)]
    table = np.array(places).reshape(-1, 3)
    return table[:, :2], table[:, 2]


def in_the_open(plan: Plan) -> tuple[Points, Points]:
    """Places every half unit over the whole section, with their fronts along the streets."""
    low: Points = plan.trodden.mins - 2.0
    high: Points = plan.trodden.maxes + 2.0
    across, along = np.meshgrid(np.arange(low[0], high[0], 0.5), np.arange(low[1], high[1], 0.5), indexing="ij")
    places = np.stack([across.ravel(), along.ravel()], axis=1)
    fronts: Points = 90.0 * (np.arange(len(places), dtype=np.float64) % 4)
    return places, fronts


def outside(plan: Plan, places: Points, halves: Points | float = 0.0) -> Points:
    """(n,): how far things of half extents `halves` are from the nearest building, along the farther axis, in units.

    0 where they reach into one.
    """
    nearest = np.full(len(places), np.inf)
    across, along = places.T
    half_across, half_along = np.broadcast_to(halves, places.shape).T
    for (left, near), (right, far) in zip(plan.low.tolist(), plan.high.tolist(), strict=True):
        sideways = np.maximum(left - across, across - right) - half_across
        lengthways = np.maximum(near - along, along - far) - half_along
        nearest = np.minimum(nearest, np.maximum(sideways, lengthways))
    apart: Points = np.maximum(nearest, 0.0)
    return apart


def in_view(plan: Plan, places: Points) -> Mask:
    """(n,): whether no building stands between a place and the nearest point of a path."""
    nearest = plan.trodden.data[plan.trodden.query(places)[1]]
    clear = np.ones(len(places), dtype=bool)
    for fraction in np.linspace(0.0, 1.0, 12):
        clear &= outside(plan, places + fraction * (nearest - places)) > 0.0
    return clear


def place(plan: Plan, kind: str, places: Points, fronts: Points, random: Random) -> None:
    """Adds one thing of this kind, far from others of its kind, unless there is no room left."""
    radius = max(extents(kind))
    room = free_of_others(plan, places, radius)
    chosen = np.flatnonzero(room)
    if not len(chosen):
        return
    tried = [int(chosen[random.randrange(len(chosen))]) for _ in range(6)]
    same = [spot for spot, prop in zip(plan.spots, plan.placed, strict=True) if prop.kind == kind]
    best = max(tried, key=lambda i: min((np.hypot(*(places[i] - spot[:2])) for spot in same), default=0.0))
    across, along = (float(value) for value in places[best])
    x, z = turn_back(places[best][None, :], plan.heading)[0]
    colour = random.choice(COLOURS.get(kind, ("",)))
    shape = random.choice(SHAPES) if kind == "banner" else ""
    shape_colour = random.choice(SHAPE_COLOURS[colour]) if kind == "banner" else ""
    front = round(wrap(float(fronts[best]) + plan.heading), 3)
    plan.placed.append(Prop(kind, round(float(x), 3), round(float(z), 3), front, colour, shape, shape_colour))
    plan.spots.append((across, along, radius))


def free_of_others(plan: Plan, places: Points, radius: float) -> Mask:
    """(n,): which places leave half a unit between a thing of `radius` and everything that stands already."""
    room = np.ones(len(places), dtype=bool)
    for across, along, other in plan.spots:
        room &= np.hypot(places[:, 0] - across, places[:, 1] - along) > radius + other + 0.5
    return room
