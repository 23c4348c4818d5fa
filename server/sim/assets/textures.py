"""Procedural textures of the ground and the room, and the drawing functions of all textures.

Every texture is a (height, width, 3) uint8 array, its first row at the top, and the same on every machine: random
values come from a seeded generator.
"""

from collections.abc import Callable
from functools import cache

import numpy as np
import numpy.typing as npt

Image = npt.NDArray[np.uint8]
Colour = tuple[int, int, int]

GROUND_SPAN = 4.0
"""Size of one texture of asphalt, pavement or roof, in units."""


def plain(height: int, width: int, colour: Colour) -> Image:
    """Return an image of a single colour."""
    return np.full((height, width, 3), colour, np.uint8)


def speckled(image: Image, amount: float, seed: int, grain: int = 1) -> Image:
    """Return the image with its brightness varied by up to `amount` (of 255), in grains of `grain` pixels."""
    height, width = image.shape[:2]
    rng = np.random.default_rng(seed)
    coarse = rng.uniform(-amount, amount, (-(-height // grain), -(-width // grain)))
    noise = np.kron(coarse, np.ones((grain, grain)))[:height, :width, None]
    return np.clip(image + noise, 0, 255).astype(np.uint8)


def fill(image: Image, left: float, top: float, right: float, bottom: float, colour: Colour) -> None:
    """Paint a rectangle; edges are in pixels, fractions are rounded."""
    image[round(top) : round(bottom), round(left) : round(right)] = colour


def paint(image: Image, mask: npt.NDArray[np.bool_], colour: Colour) -> None:
    """Paint the pixels where the mask, (height, width), is true."""
    image[mask] = colour


def grid(image: Image) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Return the pixel centres' (x to the right, y down), in pixels, in shapes that broadcast to the image's."""
    height, width = image.shape[:2]
    return np.arange(0.5, width)[None, :], np.arange(0.5, height)[:, None]


def bricks(
    height: int,
    width: int,
    colour: Colour,
    mortar: Colour,
    seed: int,
    course: int = 8,
    length: int = 16,
    vary: float = 16,
    joint: int = 1,
) -> Image:
    """Draw courses of bricks, every second one shifted by half a brick; seamless if both sizes divide the image's."""
    image = plain(height, width, mortar)
    rng = np.random.default_rng(seed)
    for i, top in enumerate(range(0, height, course)):
        shades = rng.uniform(-vary, vary, width // length)
        offset = (length // 2) * (i % 2)
        for j, shade in enumerate(shades):
            tone = np.clip(np.asarray(colour) + shade, 0, 255).astype(np.uint8)
            columns = (np.arange(j * length, (j + 1) * length - joint) + offset) % width
            image[top : top + course - joint, columns] = tone
    return image


def _asphalt() -> Image:
    image = speckled(speckled(plain(128, 128, (104, 106, 110)), 5, 11, grain=2), 4, 12, grain=16)
    x, y = grid(image)
    paint(image, (np.abs(x - 34) < 13) & (np.abs(y - 40) < 8), (94, 95, 99))  # a repaired patch
    away = np.hypot(x - 96, y - 96)
    paint(image, away < 5, (84, 84, 88))  # a manhole's lid
    paint(image, (away > 4.4) & (away < 5.6), (70, 70, 74))
    return image


def _pavement() -> Image:
    image = bricks(128, 128, (176, 172, 164), (140, 137, 130), 13, course=16, length=32, vary=8)
    return speckled(image, 5, 14)


def _roof() -> Image:
    return speckled(plain(64, 64, (96, 90, 86)), 14, 15)


def _wood() -> Image:
    """Draw upright planks with knots, for a wall one texture high."""
    image = plain(128, 128, (150, 96, 48))
    rng = np.random.default_rng(16)
    x, y = grid(image)
    for i in range(8):
        tone = np.clip(np.array([150, 96, 48]) + rng.uniform(-22, 22), 0, 255)
        wave = 5 * np.sin((x - 16 * i) * 1.1 + 2.2 * np.sin(y / 21 + i))
        plank = (x >= 16 * i) & (x < 16 * (i + 1)) & (y > 0)
        image[plank] = np.clip(tone + wave[..., None], 0, 255).astype(np.uint8)[plank]
        knot = np.hypot(x - 16 * i - 8, (y - rng.uniform(10, 118)) / 1.6)
        paint(image, knot < 3, (98, 58, 26))
        paint(image, (np.abs(x - 16 * i) < 1) & (y > 0), (84, 50, 24))
    return image


def _spotted() -> Image:
    """Draw blue-green spots in staggered rows on a cream wall."""
    image = plain(128, 128, (238, 230, 208))
    x, y = grid(image)
    for i in range(4):
        for j in range(4):
            cx, cy = 16 + 32 * j + 16 * (i % 2), 16 + 32 * i
            across = np.abs(x - cx) % 128
            paint(image, np.hypot(np.minimum(across, 128 - across), y - cy) < 10, (26, 128, 140))
    return image


def _striped() -> Image:
    """Draw broad vertical stripes of pink and white."""
    image = plain(128, 128, (244, 238, 236))
    x, y = grid(image)
    paint(image, (x % 32 < 16) & (y > 0), (206, 70, 120))
    return image


def _checkered() -> Image:
    image = plain(64, 64, (255, 224, 40))
    x, y = grid(image)
    paint(image, (x // 16 + y // 16) % 2 == 1, (206, 150, 0))
    return image


def _floor() -> Image:
    """Draw one cell: a grey tile with a dark border, so that cells can be counted."""
    image = speckled(plain(64, 64, (186, 188, 190)), 4, 17)
    x, y = grid(image)
    border = (np.minimum(x, 64 - x) < 1.5) | (np.minimum(y, 64 - y) < 1.5)
    paint(image, border, (70, 76, 84))
    return image


def _ceiling() -> Image:
    """Draw one cell: a white panel with thin joints, and a lamp in its middle."""
    image = speckled(plain(64, 64, (240, 238, 232)), 2, 19)
    x, y = grid(image)
    paint(image, np.minimum(np.minimum(x, 64 - x), np.minimum(y, 64 - y)) < 1.0, (200, 198, 192))
    paint(image, np.maximum(np.abs(x - 32), np.abs(y - 32)) < 9, (255, 255, 250))
    paint(image, np.abs(np.maximum(np.abs(x - 32), np.abs(y - 32)) - 9) < 1, (206, 206, 204))
    return image


def _brick_wall() -> Image:
    return bricks(128, 128, (172, 62, 44), (216, 204, 192), 18, course=16, length=32, joint=2)


_MAKERS: dict[str, Callable[[], Image]] = {
    "asphalt": _asphalt,
    "pavement": _pavement,
    "roof": _roof,
    "kerb": lambda: plain(8, 8, (206, 204, 196)),
    "marking": lambda: plain(8, 8, (226, 220, 190)),
    "line": lambda: plain(8, 8, (222, 216, 190)),
    "wall/wood": _wood,
    "wall/brick": _brick_wall,
    "wall/spotted": _spotted,
    "wall/striped": _striped,
    "start": _checkered,
    "floor": _floor,
    "ceiling": _ceiling,
}


@cache
def texture(name: str) -> Image:
    """Return a texture of the ground or the room by its name. Read-only: callers share it.

    Raises:
        KeyError: for an unknown name.
    """
    image = _MAKERS[name]()
    image.flags.writeable = False
    return image
