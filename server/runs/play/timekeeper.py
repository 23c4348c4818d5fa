"""Enforcement of clocks: starts them, charges overdue time, and finds episodes that are out of time."""

from collections.abc import Callable, Iterable

from server.runs.play.clocks import Bank, Clocks, StreamClock
from server.runs.play.stream import Stream
from server.runs.storage.records import Batch
from server.runs.storage.run_activity import RunActivity


class Timekeeper:
    """Enforces the clocks of all streams of this process.

    Args:
        activity: storage of the banks.
        now: returns the time of play, in seconds since an arbitrary moment.
    """

    def __init__(self, activity: RunActivity, now: Callable[[], float]) -> None:
        self._activity = activity
        self.now = now

    def start(self, stream: Stream, others: Iterable[Stream]) -> None:
        """Set the clock of a stream if its run has clocks; all streams of a run share its bank.

        Raises:
            StorageError: if the journal cannot be read.
        """
        run = stream.run
        clocks = Clocks.of(run)
        if not clocks:
            return
        shared = (other.clock.bank for other in others if other.clock is not None and other.run.run_id == run.run_id)
        bank = next(shared, None) or Bank(0.0)
        bank.left = self._activity.bank_left(run.run_id)
        bank.away_left = self._activity.away_left(run.run_id)
        bank.answered = bank.answered or self._activity.has_steps(run.run_id)
        stream.clock = StreamClock(clocks, bank, self.now)

    def check(self, stream: Stream, at: float, batch: Batch) -> list[str]:
        """Charge the overdue time of a stream until `at`; return its episodes that are out of time."""
        clock = stream.clock
        if clock is None:
            return []
        unread = clock.unread_seconds(at)
        if unread > 0.0:
            clock.bank.away_left = self._activity.add_absence(stream.run.run_id, unread)
        if clock.bank.away_left <= 0.0:
            clock.begin(at)
        clock.charge(at)
        batch.charge(stream.run.run_id, clock.take_charges())
        return clock.out_of_time(at)

    def refresh(self, stream: Stream) -> None:
        """Read the bank again, from which other processes may have drawn.

        Raises:
            StorageError: if the journal cannot be read.
        """
        if stream.clock is not None:
            stream.clock.bank.left = self._activity.bank_left(stream.run.run_id)
