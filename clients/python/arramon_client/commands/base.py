"""Exit statuses and error reporting of the client's subcommands."""

import argparse
import difflib
import os
import sys
from collections.abc import Callable, Iterable, Sequence

from arramon_client.errors import ArramonClientError, UsageError
from arramon_client.printable import many_lines
from arramon_client.stopping import describe, status_of

SUCCESS, ERROR, USAGE = 0, 1, 2
"""Exit statuses; after a signal it is 128 and the signal's number (`stopping.status_of`)."""


def run(parser: argparse.ArgumentParser, argv: Sequence[str], work: Callable[[argparse.Namespace], int | None]) -> int:
    """Parse a command's arguments, call `work` and return the exit status; errors are printed to standard error.

    Args:
        parser: the command's parser.
        argv: the arguments after the command's name.
        work: does the command's work; returns its exit status, or None for success.
    """
    try:
        status = work(parse(parser, argv)) or SUCCESS
        sys.stdout.flush()
        return status
    except SystemExit as leaving:  # argparse has printed the error
        return leaving.code if isinstance(leaving.code, int) else USAGE
    except KeyboardInterrupt as stop:
        print(describe(stop), file=sys.stderr)
        return status_of(stop)
    except BrokenPipeError:  # The reader of the output has ended, such as `head`.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # Python flushes it once more at exit.
        return ERROR
    except ArramonClientError as error:
        print(f"error: {many_lines(str(error))}", file=sys.stderr)
        return USAGE if isinstance(error, UsageError) else ERROR


def parse(parser: argparse.ArgumentParser, argv: Sequence[str]) -> argparse.Namespace:
    """Return the parsed arguments; an unknown one is reported with the option that is spelled most like it.

    Raises:
        SystemExit: if they are wrong, with status 2, after printing the reason.
    """
    options, unknown = parser.parse_known_args(argv)
    if unknown:
        known = [option for action in parser._actions for option in action.option_strings]
        parser.error(f"unrecognized arguments: {' '.join(unknown)}{nearest(unknown[0].partition('=')[0], known)}")
    return options


def nearest(word: str, known: Iterable[str]) -> str:
    """Return a question for the known word that is spelled most like an unknown one; empty if none is alike."""
    close = difflib.get_close_matches(word, list(known), n=1)
    return f"; did you mean {close[0]!r}?" if close else ""
