"""An event loop in a thread of its own, for callers without one: signals reach the main thread at once."""

import asyncio
import threading
from collections.abc import Callable, Coroutine
from concurrent.futures import Future, wait
from typing import Any, Generic, TypeVar

from arramon_client.errors import UsageError
from arramon_client.stopping import SIGNAL_SECONDS

Result = TypeVar("Result")
Notify = Callable[[str], None]

CLOSE_SECONDS = 3.0
"""Longest wait for a coroutine to end after an interrupt."""


def run_to_end(work: Callable[[Notify], Coroutine[Any, Any, Result]], notify: Notify) -> Result:
    """Run a coroutine in an event loop in a thread of its own.

    In the main thread a signal takes effect at once, also while the coroutine computes. It then has some seconds to end
    in order.

    Args:
        work: returns the coroutine, given what it calls with messages for the participant.
        notify: called with these messages, until the coroutine has ended or was interrupted.

    Raises:
        UsageError: if the caller is already in an event loop.
    """
    try:
        asyncio.get_running_loop()
    except RuntimeError:
        pass
    else:
        raise UsageError("an event loop is running: play an agent whose act is `async` with `await play_async(...)`")
    over = threading.Event()

    def notify_until_over(text: str) -> None:
        if not over.is_set():
            notify(text)

    thread = _LoopThread(work(notify_until_over))
    try:
        return thread.result()
    except KeyboardInterrupt:
        thread.cancel()
        raise
    finally:
        over.set()


class _LoopThread(Generic[Result]):
    """A thread that runs a coroutine to its end: a daemon, so that an interrupted client can exit in any case."""

    def __init__(self, work: Coroutine[Any, Any, Result]) -> None:
        self._done: Future[Result] = Future()
        self._loop: asyncio.AbstractEventLoop | None = None
        self._task: asyncio.Task[Result] | None = None
        threading.Thread(target=self._run, args=(work,), name="arramon-agent", daemon=True).start()

    def result(self) -> Result:
        """Wait for the end in pieces, so that a signal takes effect, and return the result or raise the error."""
        while not wait((self._done,), SIGNAL_SECONDS).done:
            pass
        return self._done.result()

    def cancel(self) -> None:
        """Cancel the coroutine, and wait for its end, but not long."""
        if self._loop is not None and self._task is not None and not self._done.done():
            self._loop.call_soon_threadsafe(self._task.cancel)
            wait((self._done,), CLOSE_SECONDS)

    def _run(self, work: Coroutine[Any, Any, Result]) -> None:
        async def run() -> Result:
            self._task = asyncio.ensure_future(work)
            self._loop = asyncio.get_running_loop()
            return await self._task

        try:
            self._done.set_result(asyncio.run(run()))
        except BaseException as error:  # noqa: BLE001 - raised again by `result`
            self._done.set_exception(error)
