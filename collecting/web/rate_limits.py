"""Limits of requests a minute, for each worker and for each address that tries links."""

import threading
import time
from collections import deque
from collections.abc import Callable

from arramon_server.errors import OverQuota

CHANGES_A_MINUTE = 600
"""Requests of a worker that change state: a walk sends several a second."""

TRIES_A_MINUTE = 30
"""Requests of an address that try a wrong link or token."""

_SECONDS = 60.0
_MAX_KEYS = 10_000


class RateLimits:
    """Counts requests of the last minute by key. Thread-safe.

    Args:
        clock: returns a time in seconds that only grows.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._times: dict[str, deque[float]] = {}
        self._lock = threading.Lock()

    def count(self, key: str, most: int) -> None:
        """Count a request.

        Raises:
            OverQuota: if there were `most` in the last minute already.
        """
        with self._lock:
            self._count(key, most)

    def _count(self, key: str, most: int) -> None:
        now = self._clock()
        if len(self._times) > _MAX_KEYS:
            self._times = {one: times for one, times in self._times.items() if times and times[-1] > now - _SECONDS}
        times = self._times.setdefault(key, deque())
        while times and times[0] <= now - _SECONDS:
            times.popleft()
        if len(times) >= most:
            raise OverQuota(f"more than {most} requests in a minute; wait a minute and try again")
        times.append(now)
