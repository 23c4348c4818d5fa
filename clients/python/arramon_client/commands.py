"""What every command of the client beside playing shares: its exit status, and how it says what is wrong."""

import argparse
import sys
from collections.abc import Callable, Sequence

from arramon_client.errors import ArramonClientError, UsageError

FINE, ERROR, USAGE, INTERRUPTED = 0, 1, 2, 130
"""Exit statuses."""


def run(parser: argparse.ArgumentParser, argv: Sequence[str], work: Callable[[argparse.Namespace], int | None]) -> int:
    """Parses a command's arguments and does its work; returns the exit status.

    Args:
        parser: of the command.
        argv: behind the command's word.
        work: returns its own exit status, or None where all is well.
    """
    try:
        return work(parser.parse_args(argv)) or FINE
    except SystemExit as leaving:  # argparse has said what is wrong
        return leaving.code if isinstance(leaving.code, int) else USAGE
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return INTERRUPTED
    except ArramonClientError as error:
        print(f"error: {error}", file=sys.stderr)
        return USAGE if isinstance(error, UsageError) else ERROR
