"""The obstacles of a section as rectangles on the ground, with exact distances and without pybullet."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from arramon_server.sim.assets.furniture import piece_of
from arramon_server.sim.section import Building, Prop, Section

Points = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Solids:
    """Rectangles in the world frame.

    Attributes:
        centres: (n, 2) of (x, z), in units.
        halves: (n, 2) half extents along each rectangle's own axes, in units.
        headings: (n,) of each rectangle's own z axis, degrees clockwise from +z.
    """

    centres: Points
    halves: Points
    headings: Points

    @classmethod
    def of(cls, section: Section) -> "Solids":
        """Return everything in a section that blocks agents: buildings and furniture with a collider."""
        return cls.from_bodies(section.buildings, section.props)

    @classmethod
    def from_bodies(cls, buildings: Sequence[Building], props: Sequence[Prop] = ()) -> "Solids":
        """Return the solids of these buildings and props."""
        rows = [(b.x, b.z, b.half_width, b.half_length, b.heading) for b in buildings]
        for prop in props:
            collider = piece_of(prop.kind, "" if prop.kind == "banner" else prop.colour).collider
            if collider is not None:
                rows.append((prop.x, prop.z, collider.half_width, collider.half_length, prop.heading))
        table = np.array(rows, dtype=np.float64).reshape(-1, 5)
        return cls(table[:, :2], table[:, 2:4], table[:, 4])

    def distance(self, places: Points) -> Points:
        """Return the distance of each of `places` (m, 2) of (x, z) from the nearest solid, (m,); inf without solids."""
        nearest = np.full(len(places), np.inf)
        for centre, half, heading in zip(self.centres, self.halves, self.headings, strict=True):
            np.minimum(nearest, distance_from_rectangle(places, centre, half, float(heading)), out=nearest)
        return nearest


def distance_from_rectangle(places: Points, centre: Points, half: Points, heading: float) -> Points:
    """Return the distance of each of `places` (..., 2) of (x, z) from one rectangle, in units, (...,); 0 inside it."""
    angle = np.radians(heading)
    sin, cos = np.sin(angle), np.cos(angle)
    offset = places - centre
    across = np.abs(offset[..., 0] * cos - offset[..., 1] * sin) - half[0]
    along = np.abs(offset[..., 0] * sin + offset[..., 1] * cos) - half[1]
    distance: Points = np.hypot(np.maximum(across, 0.0), np.maximum(along, 0.0))
    return distance
