"""A contact sheet: the frames of one press in one picture, so that a reader sees all of them with one look."""

from collections.abc import Sequence
from pathlib import Path

from PIL import Image, ImageDraw

CAPTION = 22
"""Height of the caption above each frame, in pixels."""

FEW, LARGE, SMALL = 2, 448, 336
"""Up to FEW frames are drawn with sides of LARGE pixels, more with SMALL."""

IN_ROW = 4


def write_sheet(path: Path, frames: Sequence[tuple[str, Path]]) -> None:
    """Write a PNG with captioned frames, row by row.

    Args:
        path: file to write.
        frames: captions and JPEG files, at least one.
    """
    side = LARGE if len(frames) <= FEW else SMALL
    columns = min(len(frames), IN_ROW)
    rows = -(-len(frames) // columns)
    sheet = Image.new("RGB", (columns * side, rows * (side + CAPTION)), "white")
    draw = ImageDraw.Draw(sheet)
    for place, (caption, frame) in enumerate(frames):
        row, column = divmod(place, columns)
        left, top = column * side, row * (side + CAPTION)
        draw.text((left + 6, top + 3), caption, fill="black", font_size=15)
        with Image.open(frame) as image:
            sheet.paste(image.resize((side - 2, side - 2)), (left, top + CAPTION))
    sheet.save(path)
