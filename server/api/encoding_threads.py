"""Threads that compress images while the next frame is drawn; both work without holding Python's lock."""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

T = TypeVar("T")

MAX_THREADS = 4
"""More cannot be kept busy: one thread draws, which takes as long as compression."""


class EncodingThreads:
    """Threads of one process; on a single core there are none.

    Args:
        cores: that the process may use; None for those that it has.
    """

    def __init__(self, cores: int | None = None) -> None:
        count = min((cores or len(os.sched_getaffinity(0))) - 1, MAX_THREADS)
        self._pool = ThreadPoolExecutor(count, "encode") if count else None

    def begin(self, work: Callable[[], T]) -> Callable[[], T]:
        """Begin some work, and return a function that finishes it and returns its result, or raises its exception.

        What no thread has begun by then, as the cores are busy, is done by the caller.
        """
        if self._pool is None:
            return work
        future = self._pool.submit(work)

        def finish() -> T:
            return work() if future.cancel() else future.result()

        return finish
