"""Files of moving pictures: WebP by Pillow, MP4 by PyAV if that is installed."""

from collections.abc import Iterable
from fractions import Fraction
from itertools import chain
from pathlib import Path

from PIL import Image

from arramon_server.errors import BadInput

LAST_SECONDS = 2.0
"""Time for which the last picture of a WebP stays before it begins again."""

METHOD = 2
"""Effort of WebP, 0 to 6: with more the file shrinks by a tenth, and takes several times as long."""


def write_webp(path: Path, pictures: Iterable[Image.Image], fps: float, quality: int) -> None:
    """Write an animated WebP that repeats.

    Args:
        path: the file.
        pictures: its pictures; at least one.
        fps: pictures a second.
        quality: 0 to 100.
    """
    first, *others = pictures
    durations = [round(1000 / fps)] * len(others) + [round(1000 * LAST_SECONDS)]
    first.save(
        path, "WEBP", save_all=True, append_images=others, duration=durations, loop=0, quality=quality, method=METHOD
    )


def check_mp4() -> None:
    """Check that MP4 can be written.

    Raises:
        BadInput: if PyAV is not installed.
    """
    try:
        import av  # noqa: F401 - not at the top: it is an extra
    except ModuleNotFoundError as error:
        raise BadInput(
            "MP4 needs PyAV, which is not installed: pip install 'arramon-server[film]', or write .webp or .html"
        ) from error


def write_mp4(path: Path, pictures: Iterable[Image.Image], fps: float, quality: int) -> None:
    """Write an MP4 in H.264.

    Args:
        path: the file.
        pictures: its pictures, of even sides; at least one.
        fps: pictures a second.
        quality: 0 to 100.

    Raises:
        BadInput: if PyAV is not installed.
    """
    check_mp4()
    import av

    shown = iter(pictures)
    first = next(shown)
    with av.open(str(path), "w", format="mp4") as container:
        stream = container.add_stream("libx264", rate=Fraction(fps).limit_denominator(1000))
        stream.width, stream.height = first.size
        stream.pix_fmt = "yuv420p"
        stream.options = {"crf": str(round(45 - 0.3 * quality))}
        for picture in chain([first], shown):
            container.mux(stream.encode(av.VideoFrame.from_image(picture)))
        container.mux(stream.encode())
