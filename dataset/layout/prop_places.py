"""Candidate places for props in a section: along facades, at corners and in the open, clear of paths and targets.

All coordinates are in the street frame (see `grid`): a place is (across, along), and a front is in degrees clockwise
from the `along` axis.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache
from random import Random

import numpy as np
from scipy.spatial import cKDTree

from arramon_client.world import AGENT_RADIUS
from arramon_dataset.layout.grid import Mask, Points, to_street_frame, to_world_frame
from arramon_server.sim.assets import furniture
from arramon_server.sim.assets.furniture import footprint_radius
from arramon_server.sim.geometry import wrap
from arramon_server.sim.section import ON_WALLS, Building, Prop

PATH_GAP = AGENT_RADIUS + 0.1
"""Minimum distance between props on the ground and every path, in units."""

TARGET_GAP = 0.4
"""Minimum distance between props on the ground and every target, in units."""

AT_CORNERS = frozenset({"traffic_light", "stop_sign", "speed_sign"})
IN_THE_OPEN = frozenset({"cone", "barrel", "barrier", "hydrant"})
AT_KERBS = {"car": 0.85, "planter": 0.4}
"""Kinds that stand along the kerb, and how far their nearer side is from the wall, in units: cars beside the pavement,
planters at its edge."""

ZEBRA_REACH = 1.2
"""Radius around a zebra crossing's middle that furniture keeps clear of, in units."""

WALL_GAP = 0.06
"""Distance between a prop and the wall behind it, in units."""

TRIED = 500
"""Maximum number of places tried for each kind."""

REACH = 2.5
"""Default maximum distance of props from the nearest path, in units: farther ones would not be visible."""


@dataclass(frozen=True)
class AlignedBuildings:
    """The buildings that share one heading.

    Attributes:
        turned: heading of the buildings relative to the street frame, in degrees.
        low, high: (n, 2) opposite corners, as (across, along) in the buildings' own turned frame.
    """

    turned: float
    low: Points
    high: Points


@dataclass
class Surroundings:
    """The buildings, paths, targets and props that further props must keep clear of.

    Attributes:
        heading: of the street frame, degrees clockwise from +z.
        rows: all buildings, grouped by heading.
        walked: points on all paths.
        targets: of all episodes; None if there are none.
        reach: maximum distance of props from the nearest path, in units.
        placed: props placed so far.
        spots: (across, along, radius) of each placed prop.
    """

    heading: float
    rows: tuple[AlignedBuildings, ...]
    walked: cKDTree
    targets: cKDTree | None
    reach: float = REACH
    placed: list[Prop] = field(default_factory=list)
    spots: list[tuple[float, float, float]] = field(default_factory=list)

    @classmethod
    def of(
        cls, heading: float, buildings: Sequence[Building], walked: Points, targets: Points, reach: float = REACH
    ) -> "Surroundings":
        """Return the surroundings in a section without props.

        Args:
            heading: of the street frame, degrees clockwise from +z.
            buildings: of the section.
            walked: (n, 2) of (x, z): closely spaced points on all paths.
            targets: (m, 2) of (x, z), m may be 0.
            reach: maximum distance of props from the nearest path, in units.
        """
        rows = []
        for own in sorted({building.heading for building in buildings}):
            members = [building for building in buildings if building.heading == own]
            centres = to_street_frame(np.array([[b.x, b.z] for b in members]), own)
            halves = np.array([[b.half_width, b.half_length] for b in members])
            rows.append(AlignedBuildings(own - heading, centres - halves, centres + halves))
        paths = cKDTree(to_street_frame(walked, heading))
        return cls(
            heading, tuple(rows), paths, cKDTree(to_street_frame(targets, heading)) if len(targets) else None, reach
        )

    def add(self, kind: str, place: Points, front: float, look: tuple[str, str, str]) -> None:
        """Add a prop.

        Args:
            kind: of the prop.
            place: (2,).
            front: direction that it faces, in degrees in the street frame.
            look: its colour, shape and shape's colour.
        """
        x, z = to_world_frame(place[None, :], self.heading)[0]
        facing = round(wrap(front + self.heading), 3)
        self.placed.append(Prop(kind, round(float(x), 3), round(float(z), 3), facing, *look))
        self.spots.append((float(place[0]), float(place[1]), reach_of(kind)))


def candidate_places(surroundings: Surroundings, kind: str, random: Random) -> tuple[Points, Points]:
    """Return random places for a prop of this kind, clear of buildings, paths and targets: (n, 2), fronts (n,)."""
    half_width, half_length = half_size(kind)
    if kind in ON_WALLS:
        places, fronts = wall_places(surroundings, 0.0, half_width)
        clear = is_wall_clear(surroundings, places, fronts, half_width) & (
            surroundings.walked.query(places)[0] < surroundings.reach
        )
        places, fronts = sample_places(places[clear], fronts[clear], random)
        clear = is_in_view(surroundings, places + 0.1 * front_vectors(fronts))
        return places[clear], fronts[clear]
    if kind in AT_CORNERS:
        places, fronts = corner_places(surroundings, half_width + WALL_GAP)
    elif kind in IN_THE_OPEN:
        places, fronts = open_places(surroundings)
    elif kind == "car":
        # Cars stand along the street, on one side with traffic, on the other against it.
        places, fronts = wall_places(surroundings, half_width + AT_KERBS[kind], half_length)
        fronts = (fronts + 90.0) % 360.0
    elif kind in AT_KERBS:
        places, fronts = wall_places(surroundings, half_length + AT_KERBS[kind], half_width)
    else:
        places, fronts = wall_places(surroundings, half_length + WALL_GAP, half_width)
    radius = footprint_radius(kind)
    distance, _ = surroundings.walked.query(places)
    clear = (distance >= PATH_GAP + radius + 0.01) & (distance < surroundings.reach)
    clear &= building_distance(surroundings, places, fronts, (half_width, half_length)) > 0.0
    if surroundings.targets is not None:
        clear &= surroundings.targets.query(places)[0] >= TARGET_GAP + radius
    places, fronts = sample_places(places[clear], fronts[clear], random)
    clear = is_in_view(surroundings, places)
    return places[clear], fronts[clear]


def sample_places(places: Points, fronts: Points, random: Random) -> tuple[Points, Points]:
    """Return a random sample of at most TRIED places, with their fronts."""
    kept = random.sample(range(len(places)), min(TRIED, len(places)))
    return places[kept], fronts[kept]


def reach_of(kind: str) -> float:
    """Return the radius around props of this kind that others keep clear of, in units."""
    return ZEBRA_REACH if kind == "zebra_crossing" else max(half_size(kind))


@cache
def half_size(kind: str) -> tuple[float, float]:
    """Return half the size of props of this kind across and along their front, in units, over all colours."""
    meshes = [furniture.piece_of(kind, colour).mesh for colour in furniture.COLOURS.get(kind, ("",))]
    halves = np.max([np.abs(mesh.vertices[:, :2]).max(axis=0) for mesh in meshes], axis=0)
    return float(halves[0]), float(halves[1])


def front_vectors(fronts: Points) -> Points:
    """Return the unit vectors (n, 2) in the direction of the fronts (n,)."""
    angles = np.radians(fronts)
    return np.stack([np.sin(angles), np.cos(angles)], axis=1)


def is_wall_clear(surroundings: Surroundings, places: Points, fronts: Points, half_width: float) -> Mask:
    """Return which places have no other building within half a unit in front of the whole banner, (n,)."""
    outwards = front_vectors(fronts)
    aside = outwards[:, ::-1] * np.array([1.0, -1.0])
    clear = np.ones(len(places), dtype=bool)
    for offset in (-half_width, 0.0, half_width):
        clear &= building_distance(surroundings, places + 0.5 * outwards + offset * aside) > 0.0
    return clear


def wall_places(surroundings: Surroundings, back: float, margin: float) -> tuple[Points, Points]:
    """Return places every half unit along facades, `back` units in front, `margin` units from the ends."""
    places: list[tuple[float, float, float]] = []
    for row in surroundings.rows:
        found: list[tuple[float, float, float]] = []
        for (left, near), (right, far) in zip(row.low, row.high, strict=True):
            for across in np.arange(left + margin, right - margin, 0.5):
                found += [(across, near - back, 180.0), (across, far + back, 0.0)]
            for along in np.arange(near + margin, far - margin, 0.5):
                found += [(left - back, along, 270.0), (right + back, along, 90.0)]
        places += from_row_frame(row, found)
    table = np.array(places).reshape(-1, 3)
    return table[:, :2], table[:, 2]


def corner_places(surroundings: Surroundings, back: float) -> tuple[Points, Points]:
    """Return places off the corners of buildings, facing along one of the two streets."""
    places: list[tuple[float, float, float]] = []
    for row in surroundings.rows:
        found: list[tuple[float, float, float]] = []
        for (left, near), (right, far) in zip(row.low, row.high, strict=True):
            found += [(left - back, near - back, front) for front in (180.0, 270.0)]
            found += [(right + back, near - back, front) for front in (90.0, 180.0)]
            found += [(left - back, far + back, front) for front in (0.0, 270.0)]
            found += [(right + back, far + back, front) for front in (0.0, 90.0)]
        places += from_row_frame(row, found)
    table = np.array(places).reshape(-1, 3)
    return table[:, :2], table[:, 2]


def from_row_frame(row: AlignedBuildings, places: list[tuple[float, float, float]]) -> list[tuple[float, float, float]]:
    """Convert (across, along, front) in the frame of a row's buildings to the street frame."""
    table = np.array(places).reshape(-1, 3)
    table[:, :2] = to_world_frame(table[:, :2], row.turned)
    table[:, 2] = (table[:, 2] + row.turned) % 360.0
    return [(across, along, front) for across, along, front in table.tolist()]


def open_places(surroundings: Surroundings) -> tuple[Points, Points]:
    """Return places every half unit over the whole section, with fronts along the streets."""
    low: Points = surroundings.walked.mins - 2.0
    high: Points = surroundings.walked.maxes + 2.0
    across, along = np.meshgrid(np.arange(low[0], high[0], 0.5), np.arange(low[1], high[1], 0.5), indexing="ij")
    places = np.stack([across.ravel(), along.ravel()], axis=1)
    fronts: Points = 90.0 * (np.arange(len(places), dtype=np.float64) % 4)
    return places, fronts


def building_distance(
    surroundings: Surroundings, places: Points, fronts: Points | None = None, halves: tuple[float, float] = (0.0, 0.0)
) -> Points:
    """Return the distance of props from the nearest building, along the axis with the larger gap, in units, (n,).

    Args:
        surroundings: with the buildings.
        places: (n, 2) of the props.
        fronts: (n,) of the props; None for points.
        halves: half the size of each prop across and along its front, in units.

    Returns:
        0 where a prop overlaps a building.
    """
    nearest = np.full(len(places), np.inf)
    for row in surroundings.rows:
        across, along = to_street_frame(places, row.turned).T
        half_across, half_along = half_extents(
            (np.zeros(len(places)) if fronts is None else fronts) - row.turned, halves
        )
        for (left, near), (right, far) in zip(row.low.tolist(), row.high.tolist(), strict=True):
            sideways = np.maximum(left - across, across - right) - half_across
            lengthways = np.maximum(near - along, along - far) - half_along
            nearest = np.minimum(nearest, np.maximum(sideways, lengthways))
    apart: Points = np.maximum(nearest, 0.0)
    return apart


def half_extents(fronts: Points, halves: tuple[float, float]) -> tuple[Points, Points]:
    """Return half the extent of props with these fronts (n,) along both axes, (n,) each."""
    angles = np.radians(fronts)
    # Rounded, so that props that face along an axis have exactly their own extents.
    sin, cos = np.abs(np.sin(angles).round(9)), np.abs(np.cos(angles).round(9))
    return halves[0] * cos + halves[1] * sin, halves[0] * sin + halves[1] * cos


def is_in_view(surroundings: Surroundings, places: Points) -> Mask:
    """Return which places have a free line of sight to the nearest point of a path, (n,)."""
    nearest = surroundings.walked.data[surroundings.walked.query(places)[1]]
    clear = np.ones(len(places), dtype=bool)
    for fraction in np.linspace(0.0, 1.0, 12):
        clear &= building_distance(surroundings, places + fraction * (nearest - places)) > 0.0
    return clear


def is_free_of_others(surroundings: Surroundings, places: Points, radius: float) -> Mask:
    """Return which places leave half a unit between a prop of `radius` and all props placed so far, (n,)."""
    free = np.ones(len(places), dtype=bool)
    for across, along, other in surroundings.spots:
        free &= np.hypot(places[:, 0] - across, places[:, 1] - along) > radius + other + 0.5
    return free
