"""Waiting for another process: awake for a moment, then asleep.

To wake a process takes up to a tenth of a millisecond, as long as a small frame. Where answers come soon, as between
processes that draw the same batch, it is better to look again and again; where a learner thinks for long, it is not.
"""

import os
import select
import time
from collections.abc import Iterable

SPIN_SECONDS = 0.0005
"""Time for which a process looks again and again before it sleeps, if it did not have to wait for longer last time."""


class Waiter:
    """Waits until one of some files can be read, or its other end is closed.

    Without `select.poll`, which is to say on Windows, it does not wait: reading does.

    Args:
        files: numbers of open files.
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
        """Return the files that can be read, as soon as there is one."""
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
