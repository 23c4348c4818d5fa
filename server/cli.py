"""The command line of the server: `arramon-server serve`, `generate` and the others in `server.commands`."""

import argparse
import os
import sys
from collections.abc import Sequence
from importlib import import_module

from server import __version__, logs
from server.configuring import add_common_flags, configured
from server.errors import ArraMonError
from server.setting import masked

FAMILIES = {
    "serving": ("serve", "health"),
    "data": ("import-release", "generate"),
    "looking": ("show", "stats", "check-instruction"),
    "settings": ("config",),
    "token": ("token",),
    "quota": ("quota",),
    "receipts": ("key", "rescore"),
    "transfer": ("export", "import"),
}
"""The modules of `server.commands`, and the commands of each: only that of the command given is loaded, to be quick."""


def main(argv: Sequence[str] | None = None) -> int:
    """Runs a command; returns the exit status: 0 fine, 1 something was wrong and was said, 2 usage, 130 interrupted."""
    # Before gRPC is loaded: what it would write by itself is no line of the log, and is explained with the error.
    os.environ.setdefault("GRPC_VERBOSITY", "NONE")
    given = sys.argv[1:] if argv is None else argv
    arguments = parser(given[0] if given else "").parse_args(given)
    try:
        arguments.configured = configured(vars(arguments), os.environ)
        arguments.settings = arguments.configured.config
        arguments.data = arguments.settings.data
        logs.configure(arguments.settings.log, arguments.settings.log_format)
        status: int | None = arguments.command(arguments)
        sys.stdout.flush()
    except BrokenPipeError:  # read by `head`, or a pager that was left: nothing is wrong
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except ArraMonError as error:
        print(f"arramon-server: {masked(str(error))}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("arramon-server: interrupted", file=sys.stderr)
        return 130
    return status or 0


def parser(command: str = "") -> argparse.ArgumentParser:
    """The command line of a command; the whole one for a word that is none."""
    parser = argparse.ArgumentParser(prog="arramon-server", description="The ArraMon evaluation server.")
    parser.add_argument("--version", action="version", version=f"arramon-server {__version__}")
    common = argparse.ArgumentParser(add_help=False)
    add_common_flags(common)
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    for family in [name for name, its in FAMILIES.items() if command in its] or FAMILIES:
        import_module(f"server.commands.{family}").add(commands, common)
    return parser
