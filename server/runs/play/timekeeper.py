"""Enforcement of time limits: starts clocks, charges overdue time, and finds episodes that are out of time."""

from collections.abc import Callable, Iterable

from arramon_server.runs.play.clocks import Bank, ClockSettings, StreamClock
from arramon_server.runs.play.stream import Stream
from arramon_server.runs.storage.records import CommitBatch
from arramon_server.runs.storage.run_activity import RunActivity


class Timekeeper:
    """Enforces the time limits of all streams of this process.

    Args:
        activity: storage of the banks.
        now: returns the time of play, in seconds since an arbitrary moment.
    """

    def __init__(self, activity: RunActivity, now: Callable[[], float]) -> None:
        self._activity = activity
        self.now = now

    def start(self, stream: Stream, streams: Iterable[Stream]) -> None:
        """Give a stream a clock if its run has time limits; all streams of a run share its bank.

        Raises:
            StorageError: if the journal cannot be read.
        """
        if not ClockSettings.of(stream.run):
            return
        shared = (other.clock.bank for other in streams if other.clock and other.run.run_id == stream.run.run_id)
        stream.clock = StreamClock(stream.run.step_seconds, next(shared, None) or Bank(0.0), self.now)
        self.refresh(stream)

    def check(self, stream: Stream, at: float, batch: CommitBatch) -> list[str]:
        """Charge a stream's overdue time until `at`, and return its episodes that are out of time."""
        clock = stream.clock
        if clock is None:
            return []
        if stream.is_congested:
            clock.begin_all()
        clock.charge(at)
        batch.charge(stream.run.run_id, clock.take_charges())
        return clock.out_of_time(at)

    def refresh(self, stream: Stream) -> None:
        """Reload the bank, which absences and other processes may have charged.

        Raises:
            StorageError: if the journal cannot be read.
        """
        if stream.clock is not None:
            stream.clock.bank.left = self._activity.bank_left(stream.run.run_id)
