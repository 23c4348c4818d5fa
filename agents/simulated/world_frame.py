"""Transformation between an agent's own frame, which begins at its initial pose, and the world."""

import math
from typing import NamedTuple

from arramon_agents.mapping.body import AgentBody


class WorldFrame(NamedTuple):
    """The initial pose of an agent in the world.

    Attributes:
        x, z: place, in units.
        heading: heading in radians.
    """

    x: float
    z: float
    heading: float

    def pose_of(self, body: AgentBody) -> tuple[float, float, float]:
        """Return a body's pose (x, z, heading in radians) in the world."""
        return *self.to_world(body.x, body.z), self.heading + body.angle

    def to_world(self, x: float, z: float) -> tuple[float, float]:
        """Transform a place from the agent's own frame to the world."""
        sin, cos = math.sin(self.heading), math.cos(self.heading)
        return self.x + x * cos + z * sin, self.z - x * sin + z * cos

    def to_own(self, x: float, z: float) -> tuple[float, float]:
        """Transform a place from the world to the agent's own frame."""
        sin, cos = math.sin(self.heading), math.cos(self.heading)
        return (x - self.x) * cos - (z - self.z) * sin, (x - self.x) * sin + (z - self.z) * cos
