"""Frames, poses and headings on the ground plane.

The world frame is the official release's: x and z span the ground, y is up, and a heading is in degrees clockwise from
+z seen from above (so 90 faces +x). The frame is left-handed, as in its authors' engine; physics and cameras use the
*scene frame*, which is right-handed with z up: scene (X, Y, Z) = world (x, z, y).
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

from arramon_client.world import STEP


class Point(NamedTuple):
    """A position in the world frame, in units."""

    x: float
    y: float
    z: float


@dataclass(frozen=True, slots=True)
class Pose:
    """Position and heading on the ground.

    Attributes:
        x: units.
        z: units.
        heading: degrees clockwise from +z seen from above, in [0, 360).
    """

    x: float
    z: float
    heading: float

    def ahead(self, distance: float = STEP) -> "Pose":
        """Return the pose `distance` units ahead, with the same heading."""
        angle = math.radians(self.heading)
        return Pose(self.x + distance * math.sin(angle), self.z + distance * math.cos(angle), self.heading)

    def turned(self, degrees: float) -> "Pose":
        """Return the pose turned clockwise by `degrees`."""
        return Pose(self.x, self.z, wrap(self.heading + degrees))

    def local(self, x: float, z: float) -> tuple[float, float]:
        """Return the point (x, z) relative to this pose: (units to the right, units ahead)."""
        angle = math.radians(self.heading)
        dx, dz, sin, cos = x - self.x, z - self.z, math.sin(angle), math.cos(angle)
        return dx * cos - dz * sin, dx * sin + dz * cos


def wrap(degrees: float) -> float:
    """Return the angle in [0, 360)."""
    wrapped = degrees % 360.0
    return 0.0 if wrapped == 360.0 else wrapped  # -1e-20 % 360.0 is 360.0
