"""Command line of the server: `arramon-server serve` and the other commands in `arramon_server.commands`.

Installed packages can add commands, such as `generate`, with an entry point in the group `arramon.commands`: the
command's name, and a module whose function `add` adds its parser.
"""

import argparse
import difflib
import os
import sys
from collections.abc import Mapping, Sequence
from importlib import import_module
from importlib.metadata import entry_points
from typing import Any, NoReturn

from arramon_client.stopping import describe, status_of, stopped_by_signals
from arramon_server import __version__
from arramon_server.commands import ENTRY_POINTS
from arramon_server.configuration.secret_masking import mask_secrets
from arramon_server.configuration.sources import add_common_flags, load_configuration, wants_json
from arramon_server.errors import ArraMonError
from arramon_server.process import logs
from arramon_server.visible_text import shown

FAMILIES = {
    "serve": ("serve", "health"),
    "config": ("config",),
    "token": ("token",),
    "quota": ("quota",),
    "runs": ("runs",),
    "film": ("film",),
    "prune": ("prune",),
    "account": ("account",),
    "receipts": ("key", "rescore"),
    "void": ("void",),
    "transfer": ("export", "import"),
    "backup": ("backup",),
    "epoch": ("epoch",),
}
"""Modules of `arramon_server.commands` and their commands. Only the module of the given command is imported."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command.

    Returns:
        Exit status: 0 success, 1 error (printed), 2 wrong usage; 128 plus the signal's number after Ctrl-C (130),
        SIGTERM (143) or SIGHUP (129).
    """
    _silence_grpc()
    with stopped_by_signals():  # `serve` replaces these handlers by its own.
        return _run(argv)


def _run(argv: Sequence[str] | None) -> int:
    words = sys.argv[1:] if argv is None else argv
    if words and not words[0].startswith("-") and not _modules(words[0]):
        return _report_unknown(words[0])
    arguments = parser(words[0] if words else "").parse_args(words)
    try:
        arguments.configuration = load_configuration(vars(arguments), os.environ)
        arguments.settings = arguments.configuration.config
        arguments.data = arguments.settings.data
        logs.configure(arguments.settings.log, arguments.settings.log_format)
        status: int | None = arguments.command(arguments)
        sys.stdout.flush()
    except BrokenPipeError:  # The reader, such as `head` or a pager, has ended: not an error.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except ArraMonError as error:
        _report(str(error), vars(arguments))
        return 1
    except KeyboardInterrupt as stop:
        print(f"arramon-server: {describe(stop)}", file=sys.stderr)
        return status_of(stop)
    return status or 0


def _report_unknown(word: str) -> int:
    """Print that there is no such command, and suggest the one with the most similar spelling."""
    known = list(_all_commands())
    close = difflib.get_close_matches(word, known, n=1)
    hint = f"did you mean {close[0]!r}?" if close else f"expected {', '.join(known)}"
    print(f"arramon-server: unknown command {mask_secrets(word)!r}; {hint}", file=sys.stderr)
    return 2


def _report(message: str, arguments: Mapping[str, Any]) -> None:
    """Print an error to standard error in the log's format, even if the settings could not be read."""
    # Quoted files and names must not control the terminal.
    message = "\n".join(shown(line) for line in mask_secrets(message).expandtabs(4).split("\n"))
    if wants_json(arguments, os.environ):
        print(logs.json_error_line("arramon_server.cli", message), file=sys.stderr)
    else:
        print(f"arramon-server: {message}", file=sys.stderr)


def load(argv: Sequence[str]) -> None:
    """Import the modules of the command in `argv` before `main` does."""
    _silence_grpc()
    for module in _modules(argv[0]) if argv else _all_modules():
        import_module(module)


def _silence_grpc() -> None:
    """Turn off gRPC's own output, which is not in the log's format, unless the environment asks for it.

    gRPC reads this when it is loaded.
    """
    os.environ.setdefault("GRPC_VERBOSITY", "NONE")


def parser(command: str = "") -> argparse.ArgumentParser:
    """Return the parser for one command; for all commands if there is no such command."""
    parser = _Parser(prog="arramon-server", description="The ArraMon evaluation server.")
    parser.add_argument("--version", action="version", version=f"arramon-server {__version__}")
    common = argparse.ArgumentParser(add_help=False)
    add_common_flags(common)
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    for module in _modules(command) or _all_modules():
        import_module(module).add(commands, common)
    return parser


class _Parser(argparse.ArgumentParser):
    """Argument parser that masks secrets in its error messages; subparsers inherit this class."""

    def error(self, message: str) -> NoReturn:
        super().error(mask_secrets(message))


def _own_commands() -> dict[str, str]:
    """Return the module of each of the server's own commands."""
    return {command: f"arramon_server.commands.{family}" for family, its in FAMILIES.items() for command in its}


def _all_commands() -> dict[str, str]:
    """Return the module of every command: the server's own, then those of installed packages."""
    own = _own_commands()
    added = {entry.name: entry.module for entry in entry_points(group=ENTRY_POINTS)}
    return own | {command: module for command, module in added.items() if command not in own}


def _modules(command: str) -> list[str]:
    """Return a list with the module of a command; an empty list if there is no such command."""
    commands = own if command in (own := _own_commands()) else _all_commands()
    return [commands[command]] if command in commands else []


def _all_modules() -> list[str]:
    return list(dict.fromkeys(_all_commands().values()))
