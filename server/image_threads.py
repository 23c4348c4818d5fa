"""Threads that draw and compress images beside the event loop; both work without holding Python's lock."""

import os
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from typing import TypeVar

T = TypeVar("T")

MAX_THREADS = 4
"""More cannot be kept busy: between two frames there is work that only one thread at a time can do."""


class ImageThreads:
    """Threads of one process; on a single core there are none.

    Args:
        cores: that the process may use; None for those that it has.
    """

    def __init__(self, cores: int | None = None) -> None:
        self._count = min((cores or len(os.sched_getaffinity(0))) - 1, MAX_THREADS)
        self._pool = ThreadPoolExecutor(self._count, "images") if self._count else None

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

    def run(self, works: Sequence[Callable[[], T]]) -> list[T]:
        """Do all of the work, the caller beside the threads, and return the results in order.

        No thread still works when this returns or raises.

        Raises:
            Exception: what any of the work raised.
        """
        if self._pool is None or len(works) < 2:
            return [work() for work in works]
        waiting = deque(enumerate(works))
        results: dict[int, T] = {}

        def work_on() -> None:
            while True:
                try:
                    number, work = waiting.popleft()
                except IndexError:  # all of it is taken
                    return
                results[number] = work()

        futures = [self._pool.submit(work_on) for _ in range(min(self._count, len(works) - 1))]
        try:
            work_on()
        finally:
            wait([future for future in futures if not future.cancel()])
        for future in futures:
            if not future.cancelled():
                future.result()
        return [results[number] for number in range(len(works))]
