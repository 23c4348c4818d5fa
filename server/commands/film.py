"""The command `film`: an episode of a run as an animated picture, a video or a page, from the journal."""

import argparse
import re
import sys
from pathlib import Path

from arramon_server.commands import Commands
from arramon_server.commands.journal import open_journal
from arramon_server.errors import BadInput

FORMATS = (".webp", ".mp4", ".html")

FPS, SIZE, QUALITY = 8.0, 320, 60
"""Defaults: pictures a second, side of a frame in pixels, and quality."""


def add(commands: Commands, common: argparse.ArgumentParser) -> None:
    """Add the command."""
    film = commands.add_parser(
        "film",
        parents=[common],
        help="make a film of an episode of a run, from the journal; possible while servers are running",
        description="Make a film of an episode of a run: the agent's view, the map, the instruction and its notes. "
        "It also works for hidden splits: such a film is for the host alone.",
    )
    film.add_argument("run", metavar="RUN", help="id of the run, as listed by `arramon-server runs`")
    film.add_argument("episode", metavar="EPISODE", help="id of the episode")
    film.add_argument(
        "--output", type=Path, required=True, metavar="FILE", help="file to write: .webp, .mp4 or .html (one file)"
    )
    film.add_argument("--lang", default="en", metavar="L", help="language of the labels (default: en)")
    film.add_argument("--steps", default="", metavar="A-B", help="only these steps (default: all)")
    film.add_argument("--fps", type=_number(0.5, 60.0), default=FPS, metavar="N", help="steps a second (default: 8)")
    film.add_argument(
        "--size", type=_number(64, 448), default=SIZE, metavar="N", help="side of a frame in pixels (default: 320)"
    )
    film.add_argument("--quality", type=_number(1, 100), default=QUALITY, metavar="N", help="1 to 100 (default: 60)")
    film.set_defaults(command=_film)


def _film(arguments: argparse.Namespace) -> None:
    if arguments.output.suffix.lower() not in FORMATS:
        raise BadInput(f"--output is {str(arguments.output)!r}, expected a file that ends with {', '.join(FORMATS)}")
    steps = _steps(arguments.steps)
    # Imported only here: the simulator takes half a second to load.
    from arramon_server.web.film.maker import FilmMaker, FilmSettings

    settings = FilmSettings(
        arguments.output, arguments.lang, steps, arguments.fps, int(arguments.size), int(arguments.quality)
    )
    with open_journal(arguments.settings, read_only=True) as database:
        made = FilmMaker(database, arguments.data, arguments.settings.camera).make(
            arguments.run, arguments.episode, settings
        )
    if made.hidden:
        print(f"the split {made.split} is hidden: this film shows what participants must not see", file=sys.stderr)
    print(f"{made.path}: {made.pictures} pictures, {made.path.stat().st_size:,} bytes")


def _steps(text: str) -> tuple[int, int] | None:
    """Return the first and the last step; None for all."""
    if not text:
        return None
    found = re.fullmatch(r"([0-9]{1,7})-([0-9]{1,7})", text)
    if found is None or int(found[1]) > int(found[2]):
        raise BadInput(f"--steps is {text!r}, expected the first and the last step, such as 0-60")
    return int(found[1]), int(found[2])


def _number(least: float, most: float) -> "type[float]":
    """Return a type of arguments: a number in a range."""

    def read(text: str) -> float:
        try:
            number = float(text)
        except ValueError:
            number = least - 1
        if not least <= number <= most:
            raise argparse.ArgumentTypeError(f"{text!r} is not a number from {least:g} to {most:g}")
        return number

    return read  # type: ignore[return-value]
