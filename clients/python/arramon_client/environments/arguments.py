"""Validation of single arguments: each function returns the value as a plain type, or raises BadArgument."""

import difflib
import os
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from arramon_client.environments.errors import BadArgument, UnknownArgument


def check_names(given: Iterable[str], known: Iterable[str]) -> None:
    """Check that all given argument names are known.

    Raises:
        UnknownArgument: if one is unknown; the message lists the known ones.
    """
    names = list(known)
    for name in given:
        if name not in names:
            near = difflib.get_close_matches(name, names, 1)
            hint = f"; did you mean {near[0]!r}?" if near else ""
            # The first half is worded like Python's own TypeError: TorchRL, for example, looks for it.
            raise UnknownArgument(
                f"got an unexpected keyword argument {name!r}: there is no argument {name!r}; there are "
                f"{listed(names)}{hint}"
            )


def is_whole_number(value: object) -> bool:
    """Return whether a value is an int or a NumPy integer; a bool is not."""
    return isinstance(value, int | np.integer) and not isinstance(value, bool)


def whole_number(name: str, value: object, expected: str, least: int | None = None) -> int:
    """Return a whole number, given as an int or a NumPy integer, as an int.

    Raises:
        BadArgument: if the value is not a whole number, or is below `least`.
    """
    if isinstance(value, int | np.integer) and is_whole_number(value) and (least is None or value >= least):
        return int(value)
    raise BadArgument(f"{name} is {value!r}, expected {expected}")


def check_seed(seed: object) -> int | None:
    """Return the seed given to `reset`, as an int; None if there is none.

    Raises:
        BadArgument: if it is neither None nor a whole number from 0.
    """
    return None if seed is None else whole_number("seed", seed, "None or a whole number from 0", 0)


def check_choice(name: str, value: object, allowed: Sequence[str | int | None]) -> None:
    """Check that a value is one of the allowed ones.

    Raises:
        BadArgument: if it is not.
    """
    if not isinstance(value, str | int | None) or isinstance(value, bool) or value not in allowed:
        raise BadArgument(f"{name} is {value!r}, expected {listed(repr(each) for each in allowed)}")


def name_tuple(name: str, value: object, example: str) -> tuple[str, ...]:
    """Return a sequence or one-dimensional array of names as a tuple without duplicates.

    Raises:
        BadArgument: if the value is not such a sequence.
    """
    plain = value.tolist() if isinstance(value, np.ndarray) else value
    if isinstance(plain, str) or not isinstance(plain, Sequence) or not all(isinstance(each, str) for each in plain):
        raise BadArgument(f"{name} is {value!r}, expected a tuple of names, e.g. {example}")
    return tuple(dict.fromkeys(map(str, plain)))


def nonempty_text(name: str, value: object, expected: str) -> str:
    """Return a value that must be a non-empty string.

    Raises:
        BadArgument: if it is not.
    """
    if not isinstance(value, str) or not value:
        raise BadArgument(f"{name} is {value!r}, expected {expected}")
    return str(value)


def folder_path(name: str, value: object) -> Path:
    """Return a path given as a string or path object.

    Raises:
        BadArgument: if the value is not a path.
    """
    if not isinstance(value, str | os.PathLike) or not isinstance(os.fspath(value), str):
        raise BadArgument(f"{name} is {value!r}, expected a path")
    return Path(value)


def listed(values: Iterable[object]) -> str:
    """Return the values separated by commas, for a message."""
    return ", ".join(map(str, values))
