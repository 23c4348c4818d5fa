"""Where things can stand or hang in a section: along facades, at corners and in the open, in nobody's way.

Everything here is in the section's turned frame (see `grid`): a place is (across, along), and a front is in degrees
clockwise from the `along` axis.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache
from random import Random

import numpy as np
from scipy.spatial import cKDTree

from server.episodes.grid import Mask, Points, turn, turn_back
from server.sim import furniture
from server.sim.furniture import footprint_radius
from server.sim.geometry import AGENT_RADIUS, wrap
from server.sim.section import Building, Prop

PATH_GAP = AGENT_RADIUS + 0.1
"""Units that stay free between what stands on the ground and every path."""

TARGET_GAP = 0.4
"""Units that stay free between what stands on the ground and every target."""

AT_CORNERS = frozenset({"traffic_light", "stop_sign", "speed_sign"})
IN_THE_OPEN = frozenset({"cone", "barrel", "barrier", "hydrant"})

WALL_GAP = 0.06
"""Between a thing and the wall behind it, in units."""

TRIED = 500
"""Places tried for each kind."""

REACH = 2.5
"""Nothing stands farther than this from every path, in units, unless something else is said: nobody would see it."""


@dataclass(frozen=True)
class Row:
    """The buildings of one heading.

    Attributes:
        turned: their heading, less the setting's, in degrees.
        low, high: (n, 2) opposite corners, as (across, along) in the buildings' own turned frame.
    """

    turned: float
    low: Points
    high: Points


@dataclass
class Setting:
    """What furniture has to keep clear of, and what stands already.

    Attributes:
        heading: of the turned frame, degrees clockwise from +z.
        rows: all buildings.
        trodden: points along all paths.
        targets: of all episodes; None without any.
        reach: nothing stands farther than this from every path, in units.
        placed: what stands already, and of each where (across, along) and its radius.
    """

    heading: float
    rows: tuple[Row, ...]
    trodden: cKDTree
    targets: cKDTree | None
    reach: float = REACH
    placed: list[Prop] = field(default_factory=list)
    spots: list[tuple[float, float, float]] = field(default_factory=list)

    @classmethod
    def of(
        cls, heading: float, buildings: Sequence[Building], trodden: Points, targets: Points, reach: float = REACH
    ) -> "Setting":
        """The setting of a section without furniture.

        Args:
            heading: of the turned frame, degrees clockwise from +z.
            buildings: of the section.
            trodden: (n, 2) of (x, z): points close together along every path.
            targets: (m, 2) of (x, z), m may be 0.
            reach: as the attribute.
        """
        rows = []
        for own in sorted({building.heading for building in buildings}):
            members = [building for building in buildings if building.heading == own]
            centres = turn(np.array([[b.x, b.z] for b in members]), own)
            halves = np.array([[b.half_width, b.half_length] for b in members])
            rows.append(Row(own - heading, centres - halves, centres + halves))
        paths = cKDTree(turn(trodden, heading))
        return cls(heading, tuple(rows), paths, cKDTree(turn(targets, heading)) if len(targets) else None, reach)

    def add(self, kind: str, place: Points, front: float, look: tuple[str, str, str]) -> None:
        """Puts a thing up.

        Args:
            kind: of the thing.
            place: (2,).
            front: where it faces.
            look: its colour, shape and shape's colour.
        """
        x, z = turn_back(place[None, :], self.heading)[0]
        facing = round(wrap(front + self.heading), 3)
        self.placed.append(Prop(kind, round(float(x), 3), round(float(z), 3), facing, *look))
        self.spots.append((float(place[0]), float(place[1]), max(extents(kind))))


def candidates(setting: Setting, kind: str, random: Random) -> tuple[Points, Points]:
    """Some places for a thing of this kind, as far as ground, paths and targets go: (n, 2) places, (n,) fronts."""
    half_width, half_length = extents(kind)
    if kind == "banner":
        places, fronts = beside_walls(setting, 0.0, half_width)
        clear = hangs_free(setting, places, fronts, half_width) & (setting.trodden.query(places)[0] < setting.reach)
        places, fronts = some(places[clear], fronts[clear], random)
        clear = in_view(setting, places + 0.1 * ahead(fronts))
        return places[clear], fronts[clear]
    if kind in AT_CORNERS:
        places, fronts = at_corners(setting, half_width + WALL_GAP)
    elif kind in IN_THE_OPEN:
        places, fronts = in_the_open(setting)
    else:
        places, fronts = beside_walls(setting, half_length + WALL_GAP, half_width)
    radius = footprint_radius(kind)
    distance, _ = setting.trodden.query(places)
    clear = (distance >= PATH_GAP + radius + 0.01) & (distance < setting.reach)
    clear &= outside(setting, places, fronts, (half_width, half_length)) > 0.0
    if setting.targets is not None:
        clear &= setting.targets.query(places)[0] >= TARGET_GAP + radius
    places, fronts = some(places[clear], fronts[clear], random)
    clear = in_view(setting, places)
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


def hangs_free(setting: Setting, places: Points, fronts: Points, half_width: float) -> Mask:
    """(n,): whether half a unit in front of the whole stretch of wall there is no other building."""
    outwards = ahead(fronts)
    aside = outwards[:, ::-1] * np.array([1.0, -1.0])
    clear = np.ones(len(places), dtype=bool)
    for offset in (-half_width, 0.0, half_width):
        clear &= outside(setting, places + 0.5 * outwards + offset * aside) > 0.0
    return clear


def beside_walls(setting: Setting, back: float, margin: float) -> tuple[Points, Points]:
    """Places every half unit along all facades, `back` units in front of them, `margin` units from their ends."""
    places: list[tuple[float, float, float]] = []
    for row in setting.rows:
        found: list[tuple[float, float, float]] = []
        for (left, near), (right, far) in zip(row.low, row.high, strict=True):
            for across in np.arange(left + margin, right - margin, 0.5):
                found += [(across, near - back, 180.0), (across, far + back, 0.0)]
            for along in np.arange(near + margin, far - margin, 0.5):
                found += [(left - back, along, 270.0), (right + back, along, 90.0)]
        places += turned_back(row, found)
    table = np.array(places).reshape(-1, 3)
    return table[:, :2], table[:, 2]


def at_corners(setting: Setting, back: float) -> tuple[Points, Points]:
    """Places off the corners of buildings, facing along one of the two streets."""
    places: list[tuple[float, float, float]] = []
    for row in setting.rows:
        found: list[tuple[float, float, float]] = []
        for (left, near), (right, far) in zip(row.low, row.high, strict=True):
            found += [(left - back, near - back, front) for front in (180.0, 270.0)]
            found += [(right + back, near - back, front) for front in (90.0, 180.0)]
            found += [(left - back, far + back, front) for front in (0.0, 270.0)]
            found += [(right + back, far + back, front) for front in (0.0, 90.0)]
        places += turned_back(row, found)
    table = np.array(places).reshape(-1, 3)
    return table[:, :2], table[:, 2]


def turned_back(row: Row, places: list[tuple[float, float, float]]) -> list[tuple[float, float, float]]:
    """(across, along, front) in the frame of a row's buildings as the same in the setting's frame."""
    table = np.array(places).reshape(-1, 3)
    table[:, :2] = turn_back(table[:, :2], row.turned)
    table[:, 2] = (table[:, 2] + row.turned) % 360.0
    return [(across, along, front) for across, along, front in table.tolist()]


def in_the_open(setting: Setting) -> tuple[Points, Points]:
    """Places every half unit over the whole section, with their fronts along the streets."""
    low: Points = setting.trodden.mins - 2.0
    high: Points = setting.trodden.maxes + 2.0
    across, along = np.meshgrid(np.arange(low[0], high[0], 0.5), np.arange(low[1], high[1], 0.5), indexing="ij")
    places = np.stack([across.ravel(), along.ravel()], axis=1)
    fronts: Points = 90.0 * (np.arange(len(places), dtype=np.float64) % 4)
    return places, fronts


def outside(
    setting: Setting, places: Points, fronts: Points | None = None, halves: tuple[float, float] = (0.0, 0.0)
) -> Points:
    """(n,): how far things are from the nearest building, along the farther of its axes, in units.

    Args:
        setting: with the buildings.
        places: (n, 2) of the things.
        fronts: (n,) of the things; None for points.
        halves: half of what each of them takes up across and along its front, in units.

    Returns:
        0 where they reach into a building.
    """
    nearest = np.full(len(places), np.inf)
    for row in setting.rows:
        across, along = turn(places, row.turned).T
        half_across, half_along = spans((np.zeros(len(places)) if fronts is None else fronts) - row.turned, halves)
        for (left, near), (right, far) in zip(row.low.tolist(), row.high.tolist(), strict=True):
            sideways = np.maximum(left - across, across - right) - half_across
            lengthways = np.maximum(near - along, along - far) - half_along
            nearest = np.minimum(nearest, np.maximum(sideways, lengthways))
    apart: Points = np.maximum(nearest, 0.0)
    return apart


def spans(fronts: Points, halves: tuple[float, float]) -> tuple[Points, Points]:
    """Half of what things take up along both axes, (n,) each, when they face `fronts` (n,)."""
    angles = np.radians(fronts)
    # What faces along an axis takes up exactly its own extents.
    sin, cos = np.abs(np.sin(angles).round(9)), np.abs(np.cos(angles).round(9))
    return halves[0] * cos + halves[1] * sin, halves[0] * sin + halves[1] * cos


def in_view(setting: Setting, places: Points) -> Mask:
    """(n,): whether no building stands between a place and the nearest point of a path."""
    nearest = setting.trodden.data[setting.trodden.query(places)[1]]
    clear = np.ones(len(places), dtype=bool)
    for fraction in np.linspace(0.0, 1.0, 12):
        clear &= outside(setting, places + fraction * (nearest - places)) > 0.0
    return clear


def free_of_others(setting: Setting, places: Points, radius: float) -> Mask:
    """(n,): which places leave half a unit between a thing of `radius` and everything that stands already."""
    room = np.ones(len(places), dtype=bool)
    for across, along, other in setting.spots:
        room &= np.hypot(places[:, 0] - across, places[:, 1] - along) > radius + other + 0.5
    return room
