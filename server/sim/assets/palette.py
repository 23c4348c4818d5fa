"""The texture shared by all street furniture: plain colours, hazard stripes, the faces of two road signs."""

from functools import cache

import numpy as np

from arramon_server.sim.assets.textures import Colour, Image, grid, paint, plain

COLOURS: dict[str, Colour] = {
    "black": (34, 34, 38), "dark": (62, 64, 68), "metal": (150, 154, 158), "silver": (190, 194, 198),
    "concrete": (178, 174, 166), "white": (244, 244, 240), "cream": (248, 236, 200), "glass": (172, 208, 224),
    "red": (212, 30, 34), "dark red": (142, 20, 26), "orange": (252, 112, 14), "yellow": (250, 206, 20),
    "gold": (196, 150, 44), "blue": (24, 78, 196), "dark blue": (16, 48, 124), "green": (28, 120, 62),
    "dark green": (22, 74, 44), "leaf": (64, 138, 48), "leaf light": (96, 164, 60), "bark": (96, 66, 42),
    "wood": (166, 108, 56), "lamp": (255, 240, 170), "light red": (255, 50, 40), "light amber": (255, 180, 30),
    "light green": (50, 220, 110), "rubber": (46, 46, 48),
}  # fmt: skip
"""Plain colours of street furniture."""

Region = tuple[tuple[float, float], tuple[float, float]]

STOP_FACE: Region = ((0.0, 0.5), (0.0, 0.5))
SPEED_FACE: Region = ((0.5, 1.0), (0.0, 0.5))
STRIPES: Region = ((0.505, 0.995), (0.51, 0.99))
"""Regions of the pictures: (u from, to), (v from, to)."""

_SIZE, _CELL, _ROW = 128, 8, 8

_GLYPHS = {
    "S": "111100111001111", "T": "111010010010010", "O": "111101101101111", "P": "111101111100100",
    "A": "010101111101101", "B": "110101110101110", "C": "111100100100111", "D": "110101101101110",
    "E": "111100110100111", "F": "111100110100100", "H": "101101111101101", "I": "111010010010111",
    "K": "101110100110101", "L": "100100100100111", "M": "101111111101101", "N": "111101101101101",
    "R": "110101110101101", "Y": "101101010010010", "2": "111001111100111", "5": "111100111001111",
}  # fmt: skip
"""Letters of 3 by 5 dots, row by row."""


def swatch(colour: str) -> tuple[float, float]:
    """Return the texture coordinates of a plain colour.

    Raises:
        ValueError: for a colour that is not one of COLOURS.
    """
    if colour not in COLOURS:
        raise ValueError(f"{colour!r} is not one of {', '.join(COLOURS)}")
    row, column = divmod(list(COLOURS).index(colour), _ROW)
    return (column + 0.5) * _CELL / _SIZE, 1.0 - (row + 0.5) * _CELL / _SIZE


@cache
def palette() -> Image:
    """Draw the texture, (128, 128, 3) uint8. Read-only: callers share it."""
    image = plain(_SIZE, _SIZE, COLOURS["metal"])
    for i, colour in enumerate(COLOURS.values()):
        row, column = divmod(i, _ROW)
        image[row * _CELL : (row + 1) * _CELL, column * _CELL : (column + 1) * _CELL] = colour
    half = _SIZE // 2
    image[half:, :half] = _stop_face(half)
    image[half:, half:] = _speed_face(half)
    stripes = image[:half, half:]
    x, y = grid(stripes)
    stripes[:] = COLOURS["white"]
    paint(stripes, (x + y) % 21.333 < 10.0, COLOURS["orange"])
    image.flags.writeable = False
    return image


def _stop_face(size: int) -> Image:
    face = plain(size, size, COLOURS["red"])
    x, y = grid(face)
    away = np.abs(x - size / 2) + np.abs(y - size / 2)
    edge = np.maximum(np.maximum(np.abs(x - size / 2), np.abs(y - size / 2)), away / 2**0.5)
    paint(face, edge > size / 2 - 4, COLOURS["white"])
    write(face, "STOP", 25, 3)
    return face


def _speed_face(size: int) -> Image:
    face = plain(size, size, COLOURS["white"])
    x, y = grid(face)
    edge = np.maximum(np.abs(x - size / 2), np.abs(y - size / 2))
    paint(face, (edge > size / 2 - 4) & (edge < size / 2 - 1), COLOURS["black"])
    write(face, "SPEED", 7, 2, COLOURS["black"])
    write(face, "LIMIT", 19, 2, COLOURS["black"])
    write(face, "25", 32, 5, COLOURS["black"])
    return face


def write(image: Image, text: str, top: int, dot: int, colour: Colour = COLOURS["white"]) -> None:
    """Write a horizontally centred line of text, in letters of 3 by 5 dots."""
    left = (image.shape[1] - (4 * len(text) - 1) * dot) // 2
    for i, letter in enumerate(text):
        bits = np.array([bit == "1" for bit in _GLYPHS[letter]]).reshape(5, 3)
        mask = np.kron(bits, np.ones((dot, dot), bool)).astype(bool)
        x0 = left + 4 * i * dot
        paint(image[top : top + 5 * dot, x0 : x0 + 3 * dot], mask, colour)
