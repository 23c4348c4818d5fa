"""Textures of building facades.

A texture is four storeys high (a ground floor with door and shop, three storeys of windows) and three bays wide; each
bay and storey has 64 pixels.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np

from arramon_client.world import FACADES
from arramon_server.sim.assets.textures import Colour, Image, bricks, fill, grid, paint, plain, speckled

BAYS, STOREYS = 3, 4
"""Bays and storeys of a texture. On higher buildings its upper three storeys are repeated."""

_PX = 64


@dataclass(frozen=True)
class _Look:
    """Style of a facade; lengths are in 64ths of a storey.

    Attributes:
        wall: colour of the wall; `mortar` is that of its joints.
        course: height of its bricks or slabs, and `length` their length; 0 for a plain wall.
        window: width and height; `arched` is whether its top is an arch, `panes` the number across and up.
        trim: colour of frames, sills and the cornice; `glass`, `door` and `awning` (over the shop) are colours too.
    """

    wall: Colour
    mortar: Colour
    course: int
    length: int
    window: tuple[int, int]
    trim: Colour
    glass: Colour
    door: Colour
    awning: Colour
    arched: bool = False
    panes: tuple[int, int] = (2, 2)


_LOOKS = {
    "brick": _Look(
        (150, 74, 56), (186, 158, 142), 8, 16, (26, 36),
        (236, 230, 216), (66, 86, 104), (52, 84, 62), (30, 96, 60),
    ),
    "brown": _Look(
        (116, 82, 58), (92, 64, 46), 16, 32, (24, 40),
        (186, 156, 120), (58, 60, 66), (70, 34, 24), (150, 40, 36), panes=(2, 3),
    ),
    "concrete": _Look(
        (166, 164, 158), (130, 128, 124), 32, 64, (54, 26),
        (112, 112, 112), (74, 92, 106), (60, 62, 66), (40, 70, 120), panes=(3, 1),
    ),
    "glass": _Look(
        (58, 78, 92), (40, 54, 64), 0, 0, (60, 56),
        (178, 190, 196), (104, 158, 190), (36, 46, 54), (70, 84, 92), panes=(3, 2),
    ),
    "white": _Look(
        (234, 232, 224), (206, 202, 192), 16, 64, (26, 34),
        (74, 106, 140), (70, 88, 104), (40, 76, 132), (44, 100, 168),
    ),
    "arched": _Look(
        (212, 184, 132), (182, 152, 104), 16, 32, (28, 44),
        (242, 226, 190), (62, 70, 84), (96, 58, 34), (140, 88, 40), True,
    ),
    "red": _Look(
        (176, 44, 38), (150, 34, 30), 8, 64, (28, 34),
        (248, 244, 236), (78, 96, 110), (32, 32, 36), (246, 238, 220),
    ),
    "grey": _Look(
        (122, 128, 136), (98, 104, 112), 8, 16, (32, 32),
        (224, 226, 228), (48, 56, 66), (150, 60, 30), (196, 136, 30), panes=(1, 2),
    ),
    "yellow": _Look(
        (240, 196, 60), (222, 176, 44), 32, 64, (28, 32),
        (250, 244, 228), (70, 84, 96), (110, 40, 30), (180, 60, 40),
    ),
    "green": _Look(
        (96, 148, 96), (82, 130, 84), 16, 64, (30, 30),
        (238, 240, 226), (56, 72, 76), (60, 44, 30), (210, 160, 40), panes=(2, 1),
    ),
    "blue": _Look(
        (74, 122, 190), (62, 106, 170), 16, 64, (24, 38),
        (240, 242, 246), (50, 58, 80), (160, 120, 40), (240, 240, 236), panes=(1, 3),
    ),
}  # fmt: skip


def wall_colour(name: str) -> Colour:
    """Return the colour of a facade's wall.

    Raises:
        KeyError: for a name that is not one of `section.FACADES`.
    """
    return _LOOKS[name].wall


@cache
def facade(name: str) -> Image:
    """Draw the texture of a facade, (256, 192, 3) uint8. Read-only: callers share it.

    Raises:
        KeyError: for a name that is not one of `section.FACADES`.
    """
    look = _LOOKS[name]
    height, width = STOREYS * _PX, BAYS * _PX
    seed = FACADES.index(name)
    if look.course:
        image = bricks(height, width, look.wall, look.mortar, seed, look.course, look.length, vary=7)
    else:
        image = plain(height, width, look.wall)
    image = speckled(image, 4, seed, grain=2)
    for storey in range(STOREYS - 1):
        top = storey * _PX
        for bay in range(BAYS):
            _window(image, look, bay * _PX, top)
        fill(image, 0, top + _PX - 4, width, top + _PX, _shade(look.trim, 0.85 if storey == STOREYS - 2 else 0.97))
        fill(image, 0, top + _PX - 1, width, top + _PX, _shade(look.trim, 0.6))
    _ground_floor(image, look, height - _PX)
    image.flags.writeable = False
    return image


def _shade(colour: Colour, factor: float) -> Colour:
    red, green, blue = (min(255, round(part * factor)) for part in colour)
    return red, green, blue


def _window(image: Image, look: _Look, left: int, top: int) -> None:
    wide, high = look.window
    x0, y0 = left + (_PX - wide) / 2, top + (_PX - high) / 2 - 3
    _glazing(image, look, x0, y0, wide, high, look.panes)
    if look.arched:
        x, y = grid(image)
        # Above the arch is wall again.
        corner = (y < y0 + wide / 2) & (y >= y0 - 3) & (x >= x0 - 3) & (x < x0 + wide + 3)
        away = np.hypot(x - x0 - wide / 2, y - y0 - wide / 2)
        paint(image, corner & (away > wide / 2 + 2.5), look.wall)
        paint(image, corner & (away > wide / 2 - 0.5) & (away <= wide / 2 + 2.5), look.trim)
    fill(image, x0 - 4, y0 + high + 1, x0 + wide + 4, y0 + high + 4, _shade(look.trim, 0.9))


def _glazing(image: Image, look: _Look, x0: float, y0: float, wide: float, high: float, panes: tuple[int, int]) -> None:
    """Draw glass that is lighter at the top, in a frame with bars."""
    fill(image, x0 - 2, y0 - 2, x0 + wide + 2, y0 + high + 2, look.trim)
    for i, factor in enumerate((1.35, 1.15, 1.0)):
        fill(image, x0, y0 + i * high / 3, x0 + wide, y0 + (i + 1) * high / 3, _shade(look.glass, factor))
    for i in range(1, panes[0]):
        fill(image, x0 + i * wide / panes[0] - 1, y0, x0 + i * wide / panes[0] + 1, y0 + high, look.trim)
    for i in range(1, panes[1]):
        fill(image, x0, y0 + i * high / panes[1] - 1, x0 + wide, y0 + i * high / panes[1] + 1, look.trim)


def _ground_floor(image: Image, look: _Look, top: int) -> None:
    """Draw a plinth, a window, a door with a light above it, and a shop window under a striped awning."""
    bottom = top + _PX
    fill(image, 0, bottom - 6, BAYS * _PX, bottom, _shade(look.wall, 0.6))
    _glazing(image, look, 19, top + 18, 26, 28, look.panes)
    door = _PX + 21
    fill(image, door - 3, top + 10, door + 25, bottom, look.trim)
    fill(image, door, top + 14, door + 22, top + 21, _shade(look.glass, 1.3))
    fill(image, door, top + 23, door + 22, bottom - 2, look.door)
    for y0, y1 in ((26, 40), (44, 58)):
        fill(image, door + 3, top + y0, door + 10, top + y1, _shade(look.door, 1.35))
        fill(image, door + 12, top + y0, door + 19, top + y1, _shade(look.door, 1.35))
    fill(image, door + 18, top + 41, door + 20, top + 43, (230, 200, 90))
    shop = 2 * _PX
    _glazing(image, look, shop + 6, top + 22, 52, 32, (3, 1))
    for i in range(8):
        fill(image, shop + 7 * i + 4, top + 9, shop + 7 * i + 11, top + 22, look.awning if i % 2 else (246, 242, 232))
