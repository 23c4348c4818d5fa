"""Threads that draw and compress images while the event loop continues; neither holds Python's global lock."""

from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from typing import TypeVar

from arramon_client.local.cores import usable_cores

T = TypeVar("T")

MAX_THREADS = 4
"""Maximum number of threads. More cannot be kept busy, because work between frames is single-threaded."""


class ImageThreads:
    """Pool of image threads of one process; empty on a single core.

    Args:
        cores: number of cores that the process may use; None for all that are available to it.
    """

    def __init__(self, cores: int | None = None) -> None:
        self._count = min((cores or usable_cores()) - 1, MAX_THREADS)
        self._pool = ThreadPoolExecutor(self._count, "images") if self._count else None

    def begin(self, work: Callable[[], T]) -> Callable[[], T]:
        """Submit some work; return a function that waits for it and returns its result or raises its exception.

        If no thread has started the work by then, because all are busy, the returned function does it itself.
        """
        if self._pool is None:
            return work
        future = self._pool.submit(work)

        def finish() -> T:
            return work() if future.cancel() else future.result()

        return finish

    def run(self, works: Sequence[Callable[[], T]]) -> list[T]:
        """Do all of the work in the threads and the calling thread; return the results in order.

        All work has stopped when this returns or raises.

        Raises:
            Exception: the exception that any of the work raised.
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
