"""Arguments for an agent's constructor: parsed from the command line, and checked against its signature."""

import difflib
import inspect
import json
import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NoReturn

from arramon_client.errors import AgentLoadError, UsageError

MOST_ARGUMENTS = 16
LONGEST_NAME, LONGEST_VALUE, LONGEST_IN_ALL = 64, 200, 1000
"""Servers' limits: number of arguments, and length of a name, of a value, and of all together, in characters."""

_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")


def parse_arguments(typed: Sequence[str]) -> dict[str, str]:
    """Return the values by name, as typed.

    Args:
        typed: arguments as `name=value`; the value may contain `=` and may be empty.

    Raises:
        UsageError: if an argument is malformed, too long or given twice, or there are too many.
    """
    arguments: dict[str, str] = {}
    for text in typed:
        name, equals, value = text.partition("=")
        if not equals or not _NAME.fullmatch(name):
            raise UsageError(
                f"--agent-arg {text!r} is not NAME=VALUE with an ASCII identifier as the name, e.g. beam=4"
            )
        if name in arguments:
            raise UsageError(f"--agent-arg {name} is given twice: {arguments[name]!r} and {value!r}")
        if len(name) > LONGEST_NAME or len(value) > LONGEST_VALUE:
            raise UsageError(
                f"--agent-arg {name[:LONGEST_NAME]} has a name of {len(name)} and a value of {len(value)} characters; "
                f"at most {LONGEST_NAME} and {LONGEST_VALUE} are allowed, as they are recorded with the run"
            )
        if not value.isprintable():
            raise UsageError(f"--agent-arg {name} is {value!r}, expected one line without control characters")
        arguments[name] = value
    total = sum(len(name) + len(value) for name, value in arguments.items())
    if len(arguments) > MOST_ARGUMENTS or total > LONGEST_IN_ALL:
        raise UsageError(
            f"there are {len(arguments)} --agent-arg with {total} characters; at most {MOST_ARGUMENTS} with "
            f"{LONGEST_IN_ALL} are allowed, as they are recorded with the run"
        )
    return arguments


def recorded_arguments(agent: object, typed: Mapping[str, str]) -> dict[str, str]:
    """Return the arguments that a run records: the agent's attribute `recorded_arguments`, or else those typed.

    Args:
        agent: the agent.
        typed: values by name, as typed.

    Raises:
        AgentLoadError: if the attribute is not a mapping of texts that a server accepts as arguments.
    """
    own = getattr(agent, "recorded_arguments", None)
    if own is None:
        return dict(typed)
    if not isinstance(own, Mapping) or not all(isinstance(each, str) for item in own.items() for each in item):
        raise AgentLoadError(f"the agent's recorded_arguments are {own!r}; expected a mapping from names to texts")
    try:
        return parse_arguments([f"{name}={value}" for name, value in own.items()])
    except UsageError as error:
        raise AgentLoadError(f"the agent's recorded_arguments cannot be recorded: {error}") from error


def parse_value(typed: str) -> object:
    """Parse a value as JSON, or return the text itself if it is not JSON.

    `4` is a number, `true` and `null` become `True` and `None`, `[1, 2]` is a list; `w.pt` and `04` are strings, and so
    is `"4"`, without its quotes. Numbers that JSON does not have (`nan`, `Infinity`, `1e999`) are strings.
    """
    try:
        return json.loads(typed, parse_constant=_no_number, parse_float=_finite)
    except (ValueError, RecursionError):
        return typed


def _no_number(text: str) -> NoReturn:
    raise ValueError(text)


def _finite(text: str) -> float:
    number = float(text)
    if not math.isfinite(number):
        raise ValueError(text)
    return number


def check_signature(made: Callable[..., Any], arguments: Mapping[str, object], spec: str) -> None:
    """Check that a class or function accepts these keyword arguments.

    Args:
        made: the class or function that returns the agent.
        arguments: values by name.
        spec: the value of `--agent`, for messages.

    Raises:
        AgentLoadError: if it does not accept one of the arguments, or requires another one.
    """
    try:
        parameters = inspect.signature(made).parameters
    except (ValueError, TypeError):  # Some callables that are not written in Python have no signature.
        return
    name = getattr(made, "__name__", repr(made))
    kinds = (inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY)
    taken = [each.name for each in parameters.values() if each.kind in kinds]
    takes_any = any(each.kind is inspect.Parameter.VAR_KEYWORD for each in parameters.values())
    unknown = [each for each in arguments if each not in taken]
    if unknown and not takes_any:
        close = difflib.get_close_matches(unknown[0], taken, n=1)
        suggestion = f" Did you mean {close[0]}?" if close else ""
        raise AgentLoadError(
            f"agent {spec}: {name}() has no argument {unknown[0]!r}; its arguments: {_listed(taken)}.{suggestion}"
        )
    for each in parameters.values():
        if each.default is not each.empty or each.kind in (each.VAR_POSITIONAL, each.VAR_KEYWORD):
            continue
        if each.kind is each.POSITIONAL_ONLY:
            raise AgentLoadError(
                f"agent {spec}: {name}() requires {each.name!r}, which cannot be given by name: give it a default, or "
                "name a function that returns the agent"
            )
        if each.name not in arguments:
            raise AgentLoadError(
                f"agent {spec}: {name}() requires the argument {each.name!r}: add --agent-arg {each.name}=VALUE"
            )


def _listed(names: Iterable[str]) -> str:
    return ", ".join(names) or "none"
