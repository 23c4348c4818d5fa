"""Appearance of the collectibles: seven meshes, and one texture for each pattern and colour.

A texture is 0.8 units wide and high: dots are 0.133 apart along u, so the pattern is seamless if the circumference is a
multiple of that. Its uppermost eighth holds plain colours for parts without a pattern, such as a screen or pages.
"""

import math
from functools import cache

import numpy as np
import numpy.typing as npt

from arramon_client.world import COLLECTIBLES
from arramon_server.sim.assets.meshes import Vector, arc, ball, box, lathe, mapped, merge, moved, painted, quad, tube
from arramon_server.sim.catalogue import ObjectType
from arramon_server.sim.scene import Mesh

TEXTURE_SIZE = 128
_SPAN = 0.8
"""Size of a texture, in units."""

_DOT_STEP, _DOT_ROWS, _DOT_RADIUS = _SPAN / 6, 0.1, 0.037
_STRIPE_STEP, _STRIPE = 0.115, 0.046

GROUND = {
    "green": (24, 150, 50),
    "red": (222, 20, 24),
    "blue": (25, 75, 225),
    "white": (246, 246, 246),
    "yellow": (255, 214, 10),
    "brown": (122, 68, 24),
    "purple": (158, 40, 190),
}
INK = {
    "green": (240, 255, 200),
    "red": (255, 240, 235),
    "blue": (225, 245, 255),
    "white": (25, 25, 30),
    "yellow": (45, 30, 10),
    "brown": (245, 215, 165),
    "purple": (255, 225, 255),
}
"""The pattern's colour on each ground: light on dark, dark on light."""

_PARTS = ("ground", "ink", "screen", "paper", "metal", "wood", "glint", "dark")
_PART_COLOURS = {
    "screen": (28, 44, 60), "paper": (250, 240, 210), "metal": (150, 154, 160), "wood": (92, 58, 34),
    "glint": (120, 160, 185), "dark": (40, 38, 40),
}  # fmt: skip


def mesh_of(kind: str) -> Mesh:
    """Return a collectible's mesh at scale 1: within `catalogue.EXTENT`, 0.1 to 0.3 units tall, facing +Y.

    Raises:
        ValueError: for a kind that is not in the catalogue.
    """
    if kind not in COLLECTIBLES:
        raise ValueError(f"{kind!r} is not one of {', '.join(COLLECTIBLES)}")
    return _mesh(kind)


def height_of(kind: str) -> float:
    """Return a collectible's height at scale 1, in units: the base of the next one of a stack.

    Raises:
        ValueError: for a kind that is not in the catalogue.
    """
    return float(mesh_of(kind).vertices[:, 2].max())


@cache
def texture_of(kind: ObjectType) -> npt.NDArray[np.uint8]:
    """Draw the texture of a collectible: (128, 128, 3) uint8, the first row at the top. Read-only: callers share it."""
    step = _SPAN / TEXTURE_SIZE
    x = (np.arange(TEXTURE_SIZE) + 0.5) * step
    y = x[::-1, None]
    if kind.pattern == "striped":
        inked = np.broadcast_to((y + 0.7 * _STRIPE_STEP) % _STRIPE_STEP < _STRIPE, (TEXTURE_SIZE, TEXTURE_SIZE))
    else:
        row = np.floor(y / _DOT_ROWS)
        across = (x + 0.5 * _DOT_STEP * (row % 2)) % _DOT_STEP - _DOT_STEP / 2
        inked = np.hypot(across, y - (row + 0.5) * _DOT_ROWS) < _DOT_RADIUS
    image = np.where(inked[..., None], INK[kind.colour], GROUND[kind.colour]).astype(np.uint8)
    cell = TEXTURE_SIZE // len(_PARTS)
    for i, part in enumerate(_PARTS):
        own = {"ground": GROUND[kind.colour], "ink": INK[kind.colour]}
        image[:cell, i * cell : (i + 1) * cell] = own.get(part) or _PART_COLOURS[part]
    image.flags.writeable = False
    return image


def _part(name: str) -> tuple[float, float]:
    """Return the texture coordinates of a plain colour."""
    return (_PARTS.index(name) + 0.5) / len(_PARTS), 1.0 - 0.5 / len(_PARTS)


def _turned(profile: list[tuple[float, float]], sides: int = 14) -> Mesh:
    """Build a patterned solid of revolution, with a whole number of dots around its widest point."""
    girth = 2 * math.pi * max(radius for radius, _ in profile)
    return lathe(profile, sides, around=round(girth / _DOT_STEP) / 6, per_texture=_SPAN)


def _ball() -> Mesh:
    return mapped(ball(0.13, 0.13, sides=16, rings=9, per_texture=_SPAN), (0.0, 1.0), (0.0, 1.0))


def _hourglass() -> Mesh:
    bulbs = [(0.06, 0.03), (0.098, 0.055), (0.092, 0.095), (0.025, 0.15), (0.092, 0.205), (0.098, 0.24), (0.06, 0.265)]
    plate = [(0.0, 0.0), (0.118, 0.0), (0.118, 0.03), (0.0, 0.03)]
    plates = [painted(moved(lathe(plate, 14), (0.0, 0.0, z)), _part("ground")) for z in (0.0, 0.265)]
    posts = []
    for angle in (90.0, 210.0, 330.0):
        x, y = 0.108 * math.cos(math.radians(angle)), 0.108 * math.sin(math.radians(angle))
        posts.append(painted(tube([(x, y, 0.03), (x, y, 0.27)], 0.009, 4), _part("wood")))
    return merge(_turned(bulbs), *plates, *posts)


def _mug() -> Mesh:
    wall = _turned([(0.0, 0.0), (0.084, 0.0), (0.09, 0.02), (0.09, 0.2)])
    lip = painted(lathe([(0.09, 0.2), (0.076, 0.2)], 14), _part("ink"))
    inside = painted(lathe([(0.076, 0.2), (0.076, 0.05), (0.0, 0.05)], 14), _part("dark"))
    handle = painted(tube(arc((0.085, 0.0, 0.105), 0.062, -110.0, 110.0, 9), 0.016, 6), _part("ground"))
    return moved(merge(wall, lip, inside, handle), (-0.045, 0.0, 0.0))


def _tv() -> Mesh:
    cabinet = box(0.25, 0.15, 0.185, base=0.03, per_texture=_SPAN)
    screen = painted(_facing(0.15, 0.12, 0.077, 0.062), _part("screen"))
    glint = painted(_facing(0.04, 0.03, 0.079, 0.135, shift=0.035), _part("glint"))
    feet = [painted(moved(box(0.03, 0.1, 0.03), (x, 0.0, 0.0)), _part("dark")) for x in (-0.085, 0.085)]
    rods = [painted(tube([(0.0, -0.03, 0.21), (x, -0.03, 0.29)], 0.008, 4), _part("metal")) for x in (-0.09, 0.09)]
    return merge(cabinet, screen, glint, *feet, *rods)


def _facing(width: float, height: float, y: float, base: float, shift: float = 0.0) -> Mesh:
    """Build a rectangle that faces +Y."""
    x0, x1 = shift + width / 2, shift - width / 2
    corners: list[Vector] = [(x0, y, base), (x1, y, base), (x1, y, base + height), (x0, y, base + height)]
    return quad(corners, (0.0, width / _SPAN), (0.0, height / _SPAN))


def _book() -> Mesh:
    """Build an open book on its edge: patterned covers outside, pages with a picture inside."""
    leaf = merge(
        box(0.15, 0.014, 0.24, per_texture=_SPAN),
        painted(moved(box(0.136, 0.026, 0.21), (0.0, 0.02, 0.015)), _part("paper")),
        moved(_facing(0.11, 0.16, 0.035, 0.035), (0.005, 0.0, 0.0)),
    )
    opening = 36.0
    x, y = 0.075 * math.cos(math.radians(opening)), 0.075 * math.sin(math.radians(opening))
    right = moved(leaf, (x + 0.006, y - 0.055, 0.0), turn=-opening)
    left = moved(leaf, (-x - 0.006, y - 0.055, 0.0), turn=opening)
    spine = painted(moved(box(0.034, 0.02, 0.24), (0.0, -0.058, 0.0)), _part("ground"))
    return merge(left, right, spine)


def _bowl() -> Mesh:
    outside = _turned([(0.0, 0.0), (0.062, 0.0), (0.062, 0.014), (0.1, 0.035), (0.13, 0.075), (0.144, 0.125)], 16)
    lip = painted(lathe([(0.144, 0.125), (0.128, 0.125)], 16), _part("ink"))
    inside = painted(lathe([(0.128, 0.125), (0.11, 0.075), (0.075, 0.04), (0.0, 0.03)], 16), _part("ground"))
    return merge(outside, lip, inside)


def _bucket() -> Mesh:
    wall = _turned([(0.0, 0.0), (0.085, 0.0), (0.128, 0.2)])
    lip = painted(lathe([(0.128, 0.185), (0.138, 0.19), (0.138, 0.205), (0.12, 0.205)], 14), _part("metal"))
    inside = painted(lathe([(0.12, 0.205), (0.078, 0.02), (0.0, 0.02)], 14), _part("dark"))
    bail = [(x, 0.0, 0.2 + 0.75 * z) for x, _, z in arc((0.0, 0.0, 0.0), 0.122, 0.0, 180.0, 10)]
    return merge(wall, lip, inside, painted(tube(bail, 0.008, 4), _part("metal")))


@cache
def _mesh(kind: str) -> Mesh:
    makers = {
        "ball": _ball, "hourglass": _hourglass, "mug": _mug, "tv": _tv, "book": _book, "bowl": _bowl, "bucket": _bucket,
    }  # fmt: skip
    return makers[kind]()
