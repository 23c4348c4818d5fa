"""Waiting for another process: busy-wait for a moment, then sleep.

Waking up a process takes up to a tenth of a millisecond, as long as rendering a small frame. Polling is faster if the
answer comes soon, as between processes that render the same batch, but wastes time while a learner computes for long.
"""

import os
import select
import time
from collections.abc import Iterable

SPIN_SECONDS = 0.0005
"""Time for which a process polls before it sleeps, unless the previous wait was longer."""


class Waiter:
    """Waits until one of several files can be read, or its other end is closed.

    Without `select.poll`, as on Windows, it does not wait, and the caller's read blocks instead.

    Args:
        files: file descriptors.
    """

    def __init__(self, files: Iterable[int]) -> None:
        self._poll = select.poll() if hasattr(select, "poll") else None
        self._spins = True
        for file in files:
            if self._poll is not None:
                self._poll.register(file, select.POLLIN)

    def ready(self) -> list[int]:
        """Return the files that can be read now."""
        return [] if self._poll is None else [file for file, _ in self._poll.poll(0)]

    def wait(self) -> list[int]:
        """Wait for a file that can be read, and return all such files."""
        if self._poll is None:
            return []
        found = self._poll.poll(0)
        if not found:
            started = time.perf_counter()
            while self._spins and not found and time.perf_counter() - started < SPIN_SECONDS:
                os.sched_yield()
                found = self._poll.poll(0)
            found = found or self._poll.poll()
            self._spins = time.perf_counter() - started < SPIN_SECONDS
        return [file for file, _ in found]
