"""Waiting for changes that another thread makes, from synchronous and from asynchronous code.

An operation that may have to wait is a generator: it yields a future for each change that it waits for, and returns its
result. `wait_for` runs it in the calling thread, `wait_async` in an event loop, so that each operation is written once.
"""

import asyncio
from collections.abc import Generator
from concurrent.futures import Future
from typing import TypeVar

from arramon_client.stopping import SIGNAL_SECONDS

Result = TypeVar("Result")
Operation = Generator[Future[None], None, Result]


class Changes:
    """Changes of something that others wait for. Not thread-safe: its owner's lock guards all calls."""

    def __init__(self) -> None:
        self._waiting: list[Future[None]] = []

    def next(self) -> Future[None]:
        """Return a future that is done at the next change."""
        future: Future[None] = Future()
        self._waiting.append(future)
        return future

    def announce(self) -> None:
        """Wake everything that waits for a change."""
        waiting, self._waiting = self._waiting, []
        for future in waiting:
            if future.set_running_or_notify_cancel():
                future.set_result(None)


def wait_for(operation: Operation[Result]) -> Result:
    """Run an operation in this thread, and return its result."""
    try:
        while True:
            future = next(operation)
            while True:  # In pieces, so that a signal takes effect.
                try:
                    future.result(SIGNAL_SECONDS)
                    break
                except TimeoutError:
                    continue
    except StopIteration as stop:
        result: Result = stop.value
        return result
    finally:
        operation.close()


async def wait_async(operation: Operation[Result]) -> Result:
    """Run an operation in the current event loop, and return its result."""
    try:
        while True:
            await asyncio.wrap_future(next(operation))
    except StopIteration as stop:
        result: Result = stop.value
        return result
    finally:
        operation.close()
