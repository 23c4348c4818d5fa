"""Text in pictures: Latin letters in Pillow's own font, Devanagari in the font of the pages."""

import re
from collections.abc import Sequence
from functools import cache
from pathlib import Path

from PIL import ImageDraw, ImageFont, features

from arramon_server.errors import BadInput

FONT = Path(__file__).parents[1] / "static" / "hind-400.woff2"
"""Font for Devanagari; it has no Latin letters."""

Colour = tuple[int, int, int]

_DEVANAGARI = re.compile("([\u0900-\u097f\u200c\u200d]+(?: +[\u0900-\u097f\u200c\u200d]+)*)")


def wrapped(text: str, size: int, width: int, lines: int) -> list[str]:
    """Break a text into at most `lines` lines of `width` pixels; the last ends with an ellipsis if text is left out."""
    found = [""]
    for word in text.split():
        longer = f"{found[-1]} {word}".strip()
        if found[-1] and text_width(longer, size) > width:
            found.append(word)
        else:
            found[-1] = longer
    if len(found) <= lines:
        return found
    last = found[lines - 1]
    while last and text_width(f"{last}...", size) > width:
        last = last[:-1]
    return [*found[: lines - 1], f"{last}..."]


def text_width(text: str, size: int) -> float:
    """Return the width of a text, in pixels."""
    return sum(font.getlength(part) for part, font in _parts(text, size))


def write(
    draw: ImageDraw.ImageDraw,
    place: tuple[float, float],
    text: str,
    size: int,
    colour: Colour,
    *,
    centred: bool = False,
) -> None:
    """Write one line of text with its baseline at a place.

    Args:
        draw: draws on the picture.
        place: left end of the baseline, or its middle, in pixels.
        text: the text.
        size: size of the letters, in pixels.
        colour: their colour.
        centred: whether `place` is the middle.

    Raises:
        BadInput: if the text has Devanagari, and Pillow cannot shape it.
    """
    x, y = place
    if centred:
        x -= text_width(text, size) / 2
    for part, font in _parts(text, size):
        draw.text((x, y), part, fill=colour, font=font, anchor="ls")
        x += font.getlength(part)


def fitting(text: str, size: int, width: int) -> str:
    """Return a text, shortened to one line of `width` pixels."""
    return wrapped(text, size, width, 1)[0]


def _parts(text: str, size: int) -> Sequence[tuple[str, ImageFont.FreeTypeFont]]:
    """Return the parts of a text in one script each, with their fonts."""
    parts = [part for part in _DEVANAGARI.split(text) if part]
    return [(part, _devanagari(size) if _DEVANAGARI.fullmatch(part) else _latin(size)) for part in parts]


@cache
def _latin(size: int) -> ImageFont.FreeTypeFont:
    font = ImageFont.load_default(size)
    assert isinstance(font, ImageFont.FreeTypeFont)  # Pillow comes with FreeType since it has this font
    return font


@cache
def _devanagari(size: int) -> ImageFont.FreeTypeFont:
    if not features.check("raqm"):
        raise BadInput(
            "this Pillow cannot shape Devanagari (it was built without Raqm): install Pillow's own wheel, or write an "
            "HTML film"
        )
    return ImageFont.truetype(str(FONT), size)
