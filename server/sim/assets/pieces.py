"""Building blocks of street furniture: a piece's mesh and collider, and parts in a single colour."""

from dataclasses import dataclass

from arramon_server.sim.assets.meshes import Vector, lathe, merge, painted, quad, stretched
from arramon_server.sim.assets.palette import swatch
from arramon_server.sim.scene import BoxCollider, Mesh


@dataclass(frozen=True, eq=False)
class Piece:
    """Mesh and collider of a prop.

    Attributes:
        mesh: the mesh; its front faces +Y.
        collider: collider; None for pieces on a wall or flat on the ground.
    """

    mesh: Mesh
    collider: BoxCollider | None

    def scaled(self, factor: float) -> "Piece":
        """Return the piece scaled by a factor."""
        mesh = stretched(self.mesh, factor, factor, factor)
        if self.collider is None:
            return Piece(mesh, None)
        box = self.collider
        return Piece(mesh, BoxCollider(factor * box.half_width, factor * box.half_length, factor * box.height))


def in_colour(colour: str, *parts: Mesh) -> Mesh:
    """Merge parts and paint them in one of `palette.COLOURS`."""
    return painted(merge(*parts), swatch(colour))


def facing(width: float, height: float, y: float, base: float, x: float = 0.0) -> Mesh:
    """Build a rectangle that faces +Y."""
    left, right = x + width / 2, x - width / 2
    corners: list[Vector] = [(left, y, base), (right, y, base), (right, y, base + height), (left, y, base + height)]
    return quad(corners)


def pole(radius: float, height: float, sides: int = 6, base: float = 0.0) -> Mesh:
    """Build an upright pole with a flat top."""
    return lathe([(radius, base), (radius, base + height), (0.0, base + height)], sides)
