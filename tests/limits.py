"""Time limits of the programs that tests start: one that hangs fails its test, which shows where the program was."""

import os
import signal
import subprocess
from contextlib import suppress
from typing import Any

LIMIT = 600.0
"""Longest wait for a program, in seconds, if a test gives none."""

HANGING = 60.0
"""Shortest limit after which a program counts as hanging, in seconds; below it a test only looks at it."""

ABORT_SECONDS = 60.0
"""Time that an aborted program has to write where it was."""

_wait: Any = subprocess.Popen.wait
_communicate: Any = subprocess.Popen.communicate


def install() -> None:
    """From now on every wait of this process for a program has a limit, after which the program is aborted."""
    os.environ["PYTHONFAULTHANDLER"] = "1"  # Programs in Python then write, when aborted, where their threads are.
    subprocess.Popen.wait = _wait_with_limit  # type: ignore[assignment, method-assign]
    subprocess.Popen.communicate = _communicate_with_limit  # type: ignore[assignment, method-assign]


def _wait_with_limit(process: "subprocess.Popen[Any]", timeout: float | None = None) -> int:
    limit = LIMIT if timeout is None else timeout
    try:
        return int(_wait(process, limit))
    except subprocess.TimeoutExpired as late:
        _abort(process, limit, late)
        raise


def _communicate_with_limit(
    process: "subprocess.Popen[Any]", *given: Any, timeout: float | None = None, **named: Any
) -> tuple[Any, Any]:
    limit = LIMIT if timeout is None else timeout
    try:
        written: tuple[Any, Any] = _communicate(process, *given, timeout=limit, **named)
    except subprocess.TimeoutExpired as late:
        _abort(process, limit, late)
        raise
    return written


def _abort(process: "subprocess.Popen[Any]", limit: float, late: subprocess.TimeoutExpired) -> None:
    """Abort a program that hangs, and add to the error what it has written that was not read."""
    if limit < HANGING or process.poll() is not None:
        return
    process.send_signal(signal.SIGABRT)
    written: tuple[Any, Any] = (None, None)
    with suppress(subprocess.TimeoutExpired, ValueError):  # Others hold its pipes, or the test has closed them.
        written = _communicate(process, timeout=ABORT_SECONDS)
    for text in written:
        if text:
            late.add_note(text if isinstance(text, str) else text.decode(errors="replace"))
