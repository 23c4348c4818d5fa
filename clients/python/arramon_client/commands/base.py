"""Exit statuses and error reporting of the client's subcommands."""

import argparse
import sys
from collections.abc import Callable, Sequence

from arramon_client.errors import ArramonClientError, UsageError

SUCCESS, ERROR, USAGE, INTERRUPTED = 0, 1, 2, 130
"""Exit statuses."""


def run(parser: argparse.ArgumentParser, argv: Sequence[str], work: Callable[[argparse.Namespace], int | None]) -> int:
    """Parse a command's arguments, call `work` and return the exit status; errors are printed to standard error.

    Args:
        parser: the command's parser.
        argv: the arguments after the command's name.
        work: does the command's work; returns its exit status, or None for success.
    """
    try:
        return work(parser.parse_args(argv)) or SUCCESS
    except SystemExit as leaving:  # argparse has printed the error
        return leaving.code if isinstance(leaving.code, int) else USAGE
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return INTERRUPTED
    except ArramonClientError as error:
        print(f"error: {error}", file=sys.stderr)
        return USAGE if isinstance(error, UsageError) else ERROR
