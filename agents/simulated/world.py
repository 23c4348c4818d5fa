"""Geometry of a section for simulated walks: ray casting, lines of sight, collision checks."""

import math

import numpy as np
import numpy.typing as npt

from arramon_agents.compilation import compiled
from arramon_agents.perception.eyes.vocabulary import Codes, codes_of
from arramon_client.world import AGENT_RADIUS
from arramon_dataset.generation.clearance_raster import CELL, ClearanceRaster
from arramon_dataset.layout.solids import distance_from_rectangle
from arramon_server.sim.assets.furniture import piece_of
from arramon_server.sim.city import label_of_prop
from arramon_server.sim.rules import Collectible
from arramon_server.sim.section import ON_WALLS, Prop, Section

FOCAL = 112.0 / math.tan(math.radians(30.0))
"""Pixels per unit at a distance of one unit, in frames of 224 pixels."""

FILLED_SHARE = 0.55
"""Share of a thing's bounding box that its pixels fill."""

COLLECTIBLE_SIZE = 0.24
"""Approximate width and height of collectibles, in units."""

SIGHT_MARGIN = 0.45
"""Distance in front of a thing's centre at which lines of sight end, in units: the thing or a wall may be solid."""

Doubles = npt.NDArray[np.float64]


class Things:
    """Furniture and collectibles, as arrays.

    Attributes:
        places: (n, 2) of (x, z), in units.
        codes: kind, colour and look of each.
        sizes: (n, 2) width and height, in units.
        low: (n,) heights of their lower ends, in units.
        faces: (n,) direction of the front, in radians; NaN for things that are visible from all sides.
        is_crossing: (n,) whether it is a zebra crossing.
        is_collectible: (n,) whether it is a collectible.
    """

    def __init__(self, props: list[Prop], items: list[Collectible]) -> None:
        count = len(props) + len(items)
        self.places, self.sizes = np.zeros((count, 2)), np.full((count, 2), COLLECTIBLE_SIZE)
        self.low, self.faces = np.zeros(count), np.full(count, np.nan)
        self.codes: list[Codes] = []
        for number, prop in enumerate(props):
            label = label_of_prop(prop)
            self.codes.append(codes_of(label.kind, label.colour, label.look))
            self.places[number] = prop.x, prop.z
            corners = np.asarray(piece_of(prop.kind, "" if prop.kind == "banner" else prop.colour).mesh.vertices)
            low, high = corners.min(0), corners.max(0)
            self.sizes[number] = float(np.max(high[:2] - low[:2])) * 0.8, high[2] - low[2]
            self.low[number] = low[2]
            if prop.kind in ON_WALLS:
                self.faces[number] = math.radians(prop.heading)
        for number, item in enumerate(items, start=len(props)):
            self.codes.append(codes_of(item.type.kind, item.type.colour, item.type.pattern))
            self.places[number] = item.position.x, item.position.z
        self.is_crossing = np.array([prop.kind == "zebra_crossing" for prop in props] + [False] * len(items))
        self.is_collectible = np.array([False] * len(props) + [True] * len(items))


class StreetWorld:
    """Rasters of a section's clearances and buildings.

    Args:
        section: the section with its furniture.
    """

    def __init__(self, section: Section) -> None:
        self.section = section
        ground = ClearanceRaster.of(section)
        self.left, self.bottom = ground.left, ground.bottom
        self.clearance = ground.clearance
        columns, rows = ground.clearance.shape
        xs, zs = self.left + CELL * (np.arange(columns) + 0.5), self.bottom + CELL * (np.arange(rows) + 0.5)
        places = np.stack(np.meshgrid(xs, zs, indexing="ij"), axis=-1)
        self.houses = np.zeros((columns, rows), np.int16)  # The building's number, from 1.
        for number, building in enumerate(section.buildings, start=1):
            half = np.array((building.half_width, building.half_length))
            inside = distance_from_rectangle(places, np.array((building.x, building.z)), half, building.heading) <= 0.0
            self.houses[inside] = number
        self.props = [prop for prop in section.props if prop.kind != ""]

    def cast(
        self, x: float, z: float, angles: Doubles, farthest: float
    ) -> tuple[Doubles, Doubles, npt.NDArray[np.int64]]:
        """Cast rays; return their lengths to the first solid and to the first building, and the building's number or 0.

        Args:
            x, z: start of the rays, in units.
            angles: (n,) directions in radians clockwise from +z.
            farthest: maximum length of a ray, in units.
        """
        solid, wall = np.full(len(angles), np.inf), np.full(len(angles), np.inf)
        house = np.zeros(len(angles), np.int64)
        _cast(self.clearance, self.houses, (x - self.left) / CELL, (z - self.bottom) / CELL, angles, farthest / CELL,
              solid, wall, house)  # fmt: skip
        return solid * CELL, wall * CELL, house

    def are_in_sight(self, x: float, z: float, places: Doubles) -> npt.NDArray[np.bool_]:
        """Return which places, (n, 2), are visible from a place, that is, not hidden by buildings, (n,)."""
        seen = np.zeros(len(places), np.bool_)
        _see(
            self.houses,
            (x - self.left) / CELL,
            (z - self.bottom) / CELL,
            (places[:, 0] - self.left) / CELL,
            (places[:, 1] - self.bottom) / CELL,
            SIGHT_MARGIN / CELL,
            seen,
        )
        return seen

    def is_free(self, x: float, z: float, to_x: float, to_z: float, clearance: float = AGENT_RADIUS) -> bool:
        """Return whether an agent can walk straight from one place to another."""
        count = max(1, math.ceil(math.hypot(to_x - x, to_z - z) / CELL))
        shares = np.arange(1, count + 1) / count
        columns = ((x + shares * (to_x - x) - self.left) / CELL).astype(np.int64)
        rows = ((z + shares * (to_z - z) - self.bottom) / CELL).astype(np.int64)
        inside = (columns >= 0) & (rows >= 0) & (columns < self.clearance.shape[0]) & (rows < self.clearance.shape[1])
        if not inside.all():
            return False
        return bool(self.clearance[columns, rows].min() >= 1000.0 * clearance - 60.0)


@compiled
def _cast(
    clearance: npt.NDArray[np.int32],
    houses: npt.NDArray[np.int16],
    x: float,
    z: float,
    angles: Doubles,
    farthest: float,
    solid: Doubles,
    wall: Doubles,
    house: npt.NDArray[np.int64],
) -> None:
    for number in range(len(angles)):
        sin, cos = math.sin(angles[number]), math.cos(angles[number])
        far = 0.0
        while far < farthest:
            far += 0.7
            column, row = int(x + far * sin), int(z + far * cos)
            if column < 0 or row < 0 or column >= houses.shape[0] or row >= houses.shape[1]:
                break
            if clearance[column, row] == 0 and solid[number] == np.inf:
                solid[number] = far
            if houses[column, row] > 0:
                wall[number] = far
                house[number] = houses[column, row]
                break


@compiled
def _see(
    houses: npt.NDArray[np.int16],
    x: float,
    z: float,
    xs: Doubles,
    zs: Doubles,
    before: float,
    seen: npt.NDArray[np.bool_],
) -> None:
    for number in range(len(xs)):
        dx, dz = xs[number] - x, zs[number] - z
        distance = math.sqrt(dx * dx + dz * dz)
        seen[number] = True
        far = 1.0
        while far < distance - before:
            column, row = int(x + dx * far / distance), int(z + dz * far / distance)
            if column < 0 or row < 0 or column >= houses.shape[0] or row >= houses.shape[1]:
                break
            if houses[column, row] > 0:
                seen[number] = False
                break
            far += 1.0
