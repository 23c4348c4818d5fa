"""Assertions for checks, and the exceptions for a failed and a skipped check."""

from collections.abc import Callable
from typing import Any

import grpc

from arramon_client.transport.incoming import details_of


class Violation(Exception):
    """The server broke its contract; the message names the value found and the expected one."""


class Skipped(Exception):
    """The check does not apply to this server; the message says why, and what would make it run."""


def expect(condition: object, message: str) -> None:
    """Raise Violation with the message unless the condition holds."""
    if not condition:
        raise Violation(message)


def expect_equal(what: str, found: object, expected: object) -> None:
    """Raise Violation unless a value is the expected one."""
    expect(found == expected, f"{what} is {found!r}, expected {expected!r}")


def expect_refusal(what: str, work: Callable[[], Any], code: grpc.StatusCode) -> None:
    """Raise Violation unless a call is refused with this status and a non-empty message.

    Args:
        what: description of the request.
        work: makes the call.
        code: the status that the contract requires.
    """
    try:
        work()
    except grpc.RpcError as error:
        details = details_of(error).strip()
        found = error.code()
        expect(found == code, f"{what} was refused with {found.name} ({details}), expected {code.name}")
        expect(details, f"{what} was refused with {found.name} and no message, expected one that says what was wrong")
        return
    raise Violation(f"{what} was accepted, expected {code.name}")


def need(condition: object, reason: str) -> None:
    """Raise Skipped with the reason unless the condition holds."""
    if not condition:
        raise Skipped(reason)
