"""Terminal output of commands, without markup in texts from servers and files."""

import sys
from typing import Any

from rich.console import Console

from arramon_client.printable import to_json


def console(least: int = 0, *, stderr: bool = False) -> Console:
    """Return a console that does not interpret markup.

    Args:
        least: minimum width in characters: on a narrower terminal lines wrap instead of being cut off.
        stderr: whether it writes to standard error.
    """
    made = Console(stderr=stderr, markup=False, highlight=False, emoji=False)
    made.width = max(made.width, least)
    return made


def print_json(content: Any) -> None:
    """Print plain data as JSON."""
    sys.stdout.write(to_json(content))
    sys.stdout.flush()


def episodes_text(number: int) -> str:
    """Return a number of episodes with its noun: "1 episode", "24 episodes"."""
    return f"{number} episode{'s' if number != 1 else ''}"
