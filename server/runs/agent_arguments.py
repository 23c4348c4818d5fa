"""Validation of an agent's arguments, which are recorded with a run and published with it."""

import re
from collections.abc import Sequence

from arramon_server.errors import BadInput
from arramon_server.visible_text import is_visible

MOST_ARGUMENTS = 16
"""Maximum number of arguments of an agent."""

LONGEST_NAME, LONGEST_VALUE, LONGEST_IN_ALL = 64, 200, 1000
"""Maximum number of characters in an argument's name, in its value, and in all names and values of a run."""

_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")


def normalize_arguments(arguments: Sequence[tuple[str, str]]) -> tuple[tuple[str, str], ...]:
    """Validate arguments, and return them sorted by name, as their order is irrelevant.

    Args:
        arguments: pairs of a name and a value.

    Raises:
        BadInput: if there are too many arguments, one is too long, a name is not an ASCII identifier or is given twice,
            or a value is not one line of visible text.
    """
    if len(arguments) > MOST_ARGUMENTS:
        raise BadInput(f"the agent has {len(arguments)} arguments; at most {MOST_ARGUMENTS} are allowed")
    total = sum(len(name) + len(value) for name, value in arguments)
    if total > LONGEST_IN_ALL:
        raise BadInput(f"the agent's arguments have {total} characters; at most {LONGEST_IN_ALL} are allowed in total")
    for name, value in arguments:
        _check(name, value)
    names = [name for name, _ in arguments]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise BadInput(f"the agent's argument {twice!r} is given twice")
    return tuple(sorted(arguments))


def _check(name: str, value: str) -> None:
    if len(name) > LONGEST_NAME:
        raise BadInput(f"an agent's argument has a name of {len(name)} characters; at most {LONGEST_NAME} are allowed")
    if not _NAME.fullmatch(name):
        raise BadInput(f"an agent's argument has the name {name!r}, expected an ASCII identifier such as 'beam'")
    if len(value) > LONGEST_VALUE:
        raise BadInput(f"the agent's argument {name} has {len(value)} characters; at most {LONGEST_VALUE} are allowed")
    if value and not is_visible(value):
        raise BadInput(f"the agent's argument {name} is {value!r}, expected one line of visible text")
