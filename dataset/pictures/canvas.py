"""Drawing in world coordinates, and layout of pictures with text."""

import math
from collections.abc import Iterable, Sequence

from PIL import Image, ImageDraw, ImageFont

Colour = tuple[int, int, int]

BLACK, WHITE, PINK, GREEN = (20, 20, 20), (255, 255, 255), (233, 64, 150), (40, 140, 70)

SWATCHES: dict[str, Colour] = {
    "green": (46, 150, 70),
    "red": (205, 45, 45),
    "blue": (50, 90, 205),
    "white": (250, 250, 250),
    "yellow": (240, 205, 50),
    "brown": (125, 80, 45),
    "purple": (135, 60, 165),
}
"""RGB values of the collectibles' colours on maps."""


class Canvas:
    """An RGB picture of an area of the ground, with +z up.

    Args:
        bounds: (x from, z from, x to, z to), in units.
        scale: pixels per unit.
        background: its colour.
    """

    def __init__(self, bounds: tuple[float, float, float, float], scale: float, background: Colour) -> None:
        self.bounds, self.scale = bounds, scale
        size = (round((bounds[2] - bounds[0]) * scale), round((bounds[3] - bounds[1]) * scale))
        self.image = Image.new("RGB", size, background)
        self._draw = ImageDraw.Draw(self.image)

    def at(self, x: float, z: float) -> tuple[float, float]:
        """Return the pixel of a point on the ground."""
        return (x - self.bounds[0]) * self.scale, (self.bounds[3] - z) * self.scale

    def rectangle(
        self, x: float, z: float, half: tuple[float, float], heading: float, fill: Colour, outline: Colour | None = None
    ) -> None:
        """Draw a rectangle of half extents (width, length), turned clockwise by `heading` degrees."""
        angle = math.radians(heading)
        sin, cos = math.sin(angle), math.cos(angle)
        corners = [(a * half[0], b * half[1]) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
        pixels = [self.at(x + u * cos + v * sin, z - u * sin + v * cos) for u, v in corners]
        self._draw.polygon(pixels, fill=fill, outline=outline)

    def line(self, points: Iterable[tuple[float, float]], colour: Colour, width: int = 3) -> None:
        """Draw a line through points on the ground."""
        self._draw.line([self.at(x, z) for x, z in points], fill=colour, width=width, joint="curve")

    def dot(
        self, x: float, z: float, radius: float, fill: Colour | None, outline: Colour = BLACK, width: int = 1
    ) -> None:
        """Draw a circle of `radius` pixels."""
        u, v = self.at(x, z)
        self._draw.ellipse((u - radius, v - radius, u + radius, v + radius), fill=fill, outline=outline, width=width)

    def label(
        self, x: float, z: float, text: str, *, size: int = 11, anchor: str = "lm", colour: Colour = BLACK
    ) -> None:
        """Write text beside a point, outlined to be readable on any background."""
        font = ImageFont.load_default(size)
        self._draw.text(self.at(x, z), text, fill=colour, font=font, anchor=anchor, stroke_width=2, stroke_fill=WHITE)


def wrap_text(text: str, width: int) -> list[str]:
    """Break text into lines of at most `width` characters, dropping characters that the built-in font lacks."""
    words = text.encode("latin-1", "ignore").decode("latin-1").split()
    lines: list[str] = []
    for word in words:
        if lines and len(lines[-1]) + 1 + len(word) <= width:
            lines[-1] += f" {word}"
        else:
            lines.append(word)
    return lines


def add_title(picture: Image.Image, lines: Sequence[str], size: int = 14) -> Image.Image:
    """Return the picture with lines of text above it."""
    height = (size + 5) * len(lines) + 10
    whole = Image.new("RGB", (picture.width, picture.height + height), WHITE)
    draw = ImageDraw.Draw(whole)
    for number, line in enumerate(lines):
        draw.text((8, 5 + number * (size + 5)), line, fill=BLACK, font=ImageFont.load_default(size))
    whole.paste(picture, (0, height))
    return whole


def stack(pictures: Sequence[Image.Image], *, gap: int = 8) -> Image.Image:
    """Return one picture with all pictures stacked vertically."""
    width = max(picture.width for picture in pictures)
    whole = Image.new("RGB", (width, sum(picture.height + gap for picture in pictures)), WHITE)
    top = 0
    for picture in pictures:
        whole.paste(picture, (0, top))
        top += picture.height + gap
    return whole
