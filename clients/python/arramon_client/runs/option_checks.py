"""Checks of the options of `Run` and `AsyncRun`, before a server is reached."""

import math
import operator
from collections.abc import Callable, Mapping, Sequence
from os import PathLike

from arramon_client.errors import UsageError
from arramon_client.run_settings import ENCODINGS
from arramon_client.transport.incoming import RUN_ID

CODE = ("url", "commit", "image")
"""Keys of the option `code`."""

MAX_NUMBER = 2**31 - 1
"""Largest number that a request can hold."""


def check_options(options: Mapping[str, object], expected: type) -> None:
    """Check names and values of options.

    Args:
        options: the options.
        expected: the TypedDict that declares them.

    Raises:
        UsageError: if an option is unknown, or its value is not of the expected type or range.
    """
    known = expected.__optional_keys__  # type: ignore[attr-defined]  # of a TypedDict
    unknown = sorted(options.keys() - known)
    if unknown:
        raise UsageError(f"unknown option {', '.join(unknown)}; expected some of {', '.join(sorted(known))}")
    for name, value in options.items():
        is_valid, wanted = _CHECKS[name]
        if not is_valid(value):
            shown = repr(value) if name != "token" else f"of type {type(value).__name__}"
            raise UsageError(f"{name} is {shown}, expected {wanted}")


def check_text(name: str, value: object) -> None:
    """Raise UsageError unless a value is text."""
    if not isinstance(value, str):
        raise UsageError(f"{name} is {value!r}, expected text")


def check_run_id(value: object) -> None:
    """Raise UsageError unless a value is the id of a run."""
    if not isinstance(value, str) or not RUN_ID.fullmatch(value):
        raise UsageError(f"{value!r} is not the id of a run, expected 32 hexadecimal digits")


def _is_text(value: object) -> bool:
    return isinstance(value, str) and bool(value)


def _is_whole(value: object, first: int, last: int = MAX_NUMBER) -> bool:
    try:
        return not isinstance(value, bool) and first <= operator.index(value) <= last  # type: ignore[arg-type]
    except TypeError:
        return False


def _is_seconds(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and not math.isnan(value) and value >= 0


def _are_names(value: object) -> bool:
    # A string must be rejected: it is a sequence of one-letter strings.
    return (
        isinstance(value, Sequence | set | frozenset)
        and not isinstance(value, str)
        and all(isinstance(name, str) for name in value)
    )


def _is_code(value: object) -> bool:
    return (
        isinstance(value, Mapping)
        and set(value) <= set(CODE)
        and all(isinstance(place, str) for place in value.values())
    )


def _or_none(check: Callable[[object], bool]) -> Callable[[object], bool]:
    return lambda value: value is None or check(value)


_path = (_or_none(lambda value: isinstance(value, str | PathLike)), "a path")
_CHECKS: dict[str, tuple[Callable[[object], bool], str]] = {
    "server": (_or_none(_is_text), "an address, `host:port` or `unix:/path`"),
    "data": _path,
    "token": (_or_none(lambda value: isinstance(value, str)), "text"),
    "tls": (_or_none(lambda value: isinstance(value, bool)), "True or False"),
    "tls_ca": _path,
    "notify": (callable, "a function with one parameter"),
    "parallel": (_or_none(lambda value: _is_whole(value, 1)), "a whole number from 1"),
    "encoding": (
        _or_none(lambda value: isinstance(value, str) and value in ENCODINGS), f"one of {', '.join(ENCODINGS)}"
    ),
    "jpeg_quality": (_or_none(lambda value: _is_whole(value, 1, 100)), "a whole number from 1 to 100"),
    "image_size": (_or_none(lambda value: _is_whole(value, 1)), "a number of pixels"),
    "patience": (_is_seconds, "a number of seconds from 0"),
    "split": (_or_none(_is_text), "the name of a split"),
    "sensors": (_are_names, 'a sequence of names, e.g. ("rgb",), or () for none'),
    "episodes": (lambda value: _is_whole(value, 0), "a whole number from 0"),
    "episode_ids": (_are_names, 'a sequence of ids, e.g. ("55120",)'),
    "participant": (lambda value: isinstance(value, str), "text"),
    "agent_arguments": (
        lambda value: isinstance(value, Mapping) and all(map(_is_text, value)), "a mapping of names to values"
    ),
    "code": (_or_none(_is_code), f"a mapping with some of {', '.join(CODE)}"),
}  # fmt: skip
"""By option: whether a value is valid, and what is expected."""
