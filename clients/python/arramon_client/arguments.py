"""The command line's arguments."""

import argparse
import shlex
from collections.abc import Sequence
from pathlib import Path

from arramon_client.access import add_access
from arramon_client.choices import ENCODINGS

SENSORS = ("rgb", "depth", "segmentation", "pose", "oracle")


def parser() -> argparse.ArgumentParser:
    """The parser of `arramon-client`."""
    made = argparse.ArgumentParser(
        prog="arramon-client",
        allow_abbrev=False,
        description="Plays ArraMon's episodes with an agent, on a server or an embedded one, and shows the scores.",
        epilog="exit status: 0 played; 1 error; 2 wrong usage, or the agent cannot be imported; "
        "3 played, but the agent failed in some episodes; 130 interrupted",
    )
    add = made.add_argument
    add("--agent", required=True, metavar="A", help="a module (agents.random_walk), module:Class, or an installed name")
    add("--lang", metavar="L", help="language of the instructions: en, hi, ... (needed unless --resume)")
    add("--split", metavar="S", help="episodes to play (default: the server's only split with that language)")
    add("--server", metavar="ADDR", help="host:port or unix:/path (default: a server of its own, embedded)")
    add("--data", type=Path, metavar="DIR", help="the embedded server's data ($ARRAMON_DATA, or ./arramon-data)")
    add("--workers", type=_positive, metavar="N", help="processes of the embedded server (default: 1)")
    add("--episodes", type=_positive, metavar="N", help="play the first N of the split's fixed order (default: all)")
    add("--parallel", type=_positive, metavar="K", help="episodes open at once (default: 8)")
    listed = ",".join(SENSORS)
    add("--sensors", type=_sensors, metavar="LIST", help=f"of {listed}, or none (default: the agent's)")
    add("--image-size", type=_positive, metavar="N", help="side of the images in pixels (default: the server's)")
    add(
        "--encoding",
        choices=tuple(ENCODINGS),
        help="of images (default: shared or else raw on this machine; zstd, lossless too, elsewhere)",
    )
    add("--quality", type=_quality, metavar="Q", help="of JPEG images, 1 to 100 (default: the server's)")
    add("--output", type=Path, default=Path("arramon-results"), metavar="DIR", help="results (default: %(default)s)")
    add("--resume", metavar="RUN", help="go on with a run; its language, split, sensors and length are its own")
    add("--participant", default="", metavar="NAME", help="who plays (default: anonymous)")
    add("--quiet", action="store_true", help="show no progress")
    add_access(made)
    return made


def parse(argv: Sequence[str]) -> argparse.Namespace:
    """The arguments.

    Raises:
        SystemExit: if they are wrong, with status 2, after saying what is.
    """
    made = parser()
    arguments = made.parse_args(argv)
    if arguments.resume is None and arguments.lang is None:
        made.error("--lang is needed: the language of the instructions, such as --lang en")
    for option, value in (("--data", arguments.data), ("--workers", arguments.workers)):
        if arguments.server is not None and value is not None:
            made.error(f"{option} is for the embedded server, and cannot be used together with --server")
    for option in ("token", "token_file", "tls", "tls_ca"):
        if arguments.server is None and getattr(arguments, option) is not None:
            made.error(f"--{option.replace('_', '-')} is for a server of others: name it with --server")
    return arguments


def resume_command(argv: Sequence[str], run_id: str) -> str:
    """The command that goes on with a run that this one began. It is shown, so that it leaves a token out."""
    kept = []
    skip = False
    for argument in argv:
        if skip or argument.startswith(("--resume=", "--token=")):
            skip = False
        elif argument in ("--resume", "--token"):
            skip = True
        else:
            kept.append(argument)
    return shlex.join(["arramon-client", *kept, "--resume", run_id])


def _positive(text: str) -> int:
    number = int(text) if text.isdecimal() else 0
    if number < 1:
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number above 0")
    return number


def _quality(text: str) -> int:
    number = int(text) if text.isdecimal() else 0
    if not 1 <= number <= 100:
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number from 1 to 100")
    return number


def _sensors(text: str) -> tuple[str, ...]:
    if text == "none":
        return ()
    names = tuple(text.split(","))
    unknown = [name for name in names if name not in SENSORS]
    if unknown:
        raise argparse.ArgumentTypeError(f"no sensor {', '.join(map(repr, unknown))}: of {', '.join(SENSORS)}, or none")
    return names
