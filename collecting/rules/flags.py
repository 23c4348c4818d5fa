"""Flags that verifiers set: what is wrong with the text of a phase."""

from collections.abc import Iterable
from typing import Any

from arramon_client.world import PHASES, TURNS
from arramon_server.errors import BadInput, quoted

KINDS = ("unclear", "wrong", "ungrammatical", "other_language")
"""What can be wrong with a text."""

PARTS = tuple(f"{turn}-{phase}" for turn in range(1, TURNS + 1) for phase in PHASES)
"""The four texts of an episode, such as "1-navigation"."""

FLAGS = tuple(f"{part}-{kind}" for part in PARTS for kind in KINDS)
"""All flags."""


def read_flags(given: Any) -> tuple[str, ...]:
    """Return the flags of a page's message, each once, in the order of `FLAGS`.

    Raises:
        BadInput: if it is no list of flags.
    """
    if not isinstance(given, list) or len(given) > len(FLAGS):
        raise BadInput(f"flags is no list of at most {len(FLAGS)} flags")
    for flag in given:
        if flag not in FLAGS:
            raise BadInput(f"{quoted(str(flag))} is no flag, expected such as {FLAGS[0]!r}")
    return tuple(flag for flag in FLAGS if flag in given)


def kinds_by_part(flags: Iterable[str]) -> dict[str, list[str]]:
    """Return the kinds of the flags that are set, by text; texts without flags are left out."""
    found = dict[str, list[str]]()
    for flag in flags:
        part, _, kind = flag.rpartition("-")
        found.setdefault(part, []).append(kind)
    return found
