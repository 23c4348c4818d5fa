"""End times of runs by a monotonic clock, so that jumps of the wall clock do not change durations."""

import time
from collections.abc import Callable
from datetime import datetime, timedelta
from threading import Lock

from arramon_server.runs.storage.records import Run

MAX_RUNS = 10_000
"""Maximum number of runs to remember. The oldest are forgotten first; their ends use the wall clock."""


class RunDurations:
    """Start times of the runs that this process has seen, by the wall clock and by a monotonic clock. Thread-safe.

    Args:
        now: monotonic clock, in seconds.
    """

    def __init__(self, now: Callable[[], float] = time.monotonic) -> None:
        self._now = now
        self._lock = Lock()
        self._seen: dict[str, tuple[datetime, float]] = {}

    def begin(self, run: Run, at: datetime) -> None:
        """Start the clock of a run whose wall-clock time is `at` now; ignored if the run is known already."""
        with self._lock:
            if len(self._seen) >= MAX_RUNS:
                del self._seen[next(iter(self._seen))]
            self._seen.setdefault(run.run_id, (at, self._now()))

    def knows(self, run_id: str) -> bool:
        """Return whether a run is known."""
        return run_id in self._seen

    def forget(self, run_id: str) -> None:
        """Forget a run that has ended."""
        with self._lock:
            self._seen.pop(run_id, None)

    def time(self, run_id: str) -> datetime | None:
        """Return the current time as the start of a run plus the time elapsed; None if the run is not known."""
        seen = self._seen.get(run_id)
        return seen and seen[0] + timedelta(seconds=self._now() - seen[1])
