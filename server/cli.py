"""The command line of the server: `arramon-server serve`, `generate` and the others in `server.commands`."""

import argparse
import logging
import os
import sys
from collections.abc import Sequence
from pathlib import Path

from server import __version__
from server.commands import data, looking, serving
from server.errors import ArraMonError

FAMILIES = (serving, data, looking)


def main(argv: Sequence[str] | None = None) -> int:
    """Runs a command; returns the exit status: 0 fine, 1 something was wrong and was said, 2 usage, 130 interrupted."""
    arguments = _parser().parse_args(argv)
    logging.basicConfig(level=arguments.log.upper(), format="%(asctime)s %(levelname)s %(name)s: %(message)s")
    try:
        status: int | None = arguments.command(arguments)
    except ArraMonError as error:
        print(f"arramon-server: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("arramon-server: interrupted", file=sys.stderr)
        return 130
    return status or 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="arramon-server", description="The ArraMon evaluation server.")
    parser.add_argument("--version", action="version", version=f"arramon-server {__version__}")
    common = argparse.ArgumentParser(add_help=False)
    common.add_argument(
        "--data",
        type=Path,
        default=Path(os.environ.get("ARRAMON_DATA", "arramon-data")),
        help="folder with episodes and journal (default: $ARRAMON_DATA or ./arramon-data)",
    )
    common.add_argument(
        "--log", default="warning", choices=("debug", "info", "warning", "error"), help="how much to log"
    )
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")

    for family in FAMILIES:
        family.add(commands, common)
    return parser
