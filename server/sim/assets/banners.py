"""Banners: cloths on walls with a shape on a coloured background."""

import math
from functools import cache

import numpy as np
import numpy.typing as npt

from arramon_server.sim.assets.meshes import Vector, box, merge, moved, painted, quad
from arramon_server.sim.assets.textures import Colour, Image, grid, paint, plain
from arramon_server.sim.scene import Mesh

COLOURS: dict[str, Colour] = {
    "red": (206, 24, 36), "blue": (24, 66, 190), "green": (18, 132, 58), "yellow": (252, 214, 30),
    "white": (246, 246, 242), "black": (28, 28, 32), "orange": (246, 120, 20), "purple": (124, 40, 160),
    "brown": (112, 70, 38),
}  # fmt: skip

SHAPES = ("star", "diamond", "triangle", "circle", "hexagon", "dot")

WIDTH, HEIGHT, BASE = 0.9, 1.1, 0.65
"""Size of the cloth, and height of its lower edge, in units."""

_PX = (88, 72)
_ROD = 4


@cache
def banner_texture(colour: str, shape: str, shape_colour: str) -> Image:
    """Draw the cloth, (88, 72, 3) uint8, with its rod's colour in the topmost rows. Read-only: callers share it.

    Raises:
        ValueError: for an unknown colour or shape.
    """
    for word, known in ((colour, COLOURS), (shape, SHAPES), (shape_colour, COLOURS)):
        if word not in known:
            raise ValueError(f"{word!r} is not one of {', '.join(known)}")
    image = plain(*_PX, COLOURS[colour])
    x, y = grid(image)
    right, up = x - _PX[1] / 2, (_PX[0] + _ROD) / 2 - y
    paint(image, _inside(shape, right / 29.0, up / 29.0), COLOURS[shape_colour])
    edge = np.minimum(np.minimum(x, _PX[1] - x), _PX[0] - y)
    paint(image, (edge > 2) & (edge < 5) & (y > _ROD), COLOURS[shape_colour])
    image[:_ROD] = (96, 70, 40)
    image.flags.writeable = False
    return image


def _inside(shape: str, x: npt.NDArray[np.float64], y: npt.NDArray[np.float64]) -> npt.NDArray[np.bool_]:
    """Return whether each point lies in the shape that fills the unit circle."""
    if shape == "circle":
        return np.hypot(x, y) < 0.9
    if shape == "dot":
        return np.hypot(x, y) < 0.45
    corners = {
        "star": [(90 + 36 * i, 1.0 if i % 2 == 0 else 0.42) for i in range(10)],
        "diamond": [(0, 0.72), (90, 1.05), (180, 0.72), (270, 1.05)],
        "triangle": [(90, 1.0), (210, 1.0), (330, 1.0)],
        "hexagon": [(60 * i, 0.95) for i in range(6)],
    }[shape]
    points = [(r * math.cos(math.radians(a)), r * math.sin(math.radians(a))) for a, r in corners]
    inside = np.zeros(np.broadcast(x, y).shape, bool)
    for (x0, y0), (x1, y1) in zip(points, points[1:] + points[:1], strict=True):
        if y0 != y1:  # a ray to the right crosses this side
            inside ^= ((y0 > y) != (y1 > y)) & (x < (x1 - x0) * (y - y0) / (y1 - y0) + x0)
    return inside


@cache
def banner_mesh() -> Mesh:
    """Build a folded cloth under a rod: its back is in the X-Z plane, against the wall, and it faces +Y."""
    folds = 6
    edges = np.linspace(-WIDTH / 2, WIDTH / 2, folds + 1)
    depths = 0.05 + 0.018 * np.sin(np.arange(folds + 1) * 1.9)
    top = 1.0 - (_ROD + 0.5) / _PX[0]
    strips = []
    for i in range(folds):
        # Seen from its front, the cloth's left is its own +X.
        (x0, y0), (x1, y1) = (edges[folds - i], depths[folds - i]), (edges[folds - i - 1], depths[folds - i - 1])
        corners: list[Vector] = [(x0, y0, BASE), (x1, y1, BASE), (x1, y1, BASE + HEIGHT), (x0, y0, BASE + HEIGHT)]
        strips.append(quad(corners, (0.005 + 0.99 * i / folds, 0.005 + 0.99 * (i + 1) / folds), (0.005, top)))
    rod = painted(box(WIDTH + 0.12, 0.03, 0.035, base=BASE + HEIGHT - 0.01), (0.5, 1.0 - 0.5 * _ROD / _PX[0]))
    return merge(*strips, moved(rod, (0.0, 0.05, 0.0)))
