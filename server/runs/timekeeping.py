"""Holds streams to their clocks: starts them, charges what is overdue, and says what is out of time."""

from collections.abc import Callable, Iterable

from server.runs.clocks import Bank, Clocks, StreamClock
from server.runs.ledger import Ledger
from server.runs.records import Batch
from server.runs.stream import Stream


class Timekeeper:
    """Keeps the time of all streams of this process.

    Args:
        ledger: keeps the banks.
        now: the time, in seconds since some moment.
    """

    def __init__(self, ledger: Ledger, now: Callable[[], float]) -> None:
        self._ledger = ledger
        self.now = now

    def start(self, stream: Stream, others: Iterable[Stream]) -> None:
        """Gives a stream its clock, if its run has any; all streams of a run share its bank.

        Raises:
            StorageError: if the journal cannot be read.
        """
        run = stream.run
        clocks = Clocks.of(run)
        if not clocks:
            return
        shared = (other.clock.bank for other in others if other.clock is not None and other.run.run_id == run.run_id)
        bank = next(shared, None) or Bank(0.0)
        bank.left = self._ledger.bank_left(run.run_id)
        bank.away_left = self._ledger.away_left(run.run_id)
        bank.answered = bank.answered or self._ledger.has_steps(run.run_id)
        stream.clock = StreamClock(clocks, bank, self.now)

    def check(self, stream: Stream, at: float, batch: Batch) -> list[str]:
        """Charges what a stream is overdue at a time; returns its episodes that are then out of time."""
        clock = stream.clock
        if clock is None:
            return []
        unread = clock.unread(at)
        if unread > 0.0:
            clock.bank.away_left = self._ledger.absent(stream.run.run_id, unread)
        if clock.bank.away_left <= 0.0:
            clock.begin(at)
        clock.charge(at)
        batch.charge(stream.run.run_id, clock.settle())
        return clock.out_of_time(at)

    def refresh(self, stream: Stream) -> None:
        """Reads what other processes have left of the bank.

        Raises:
            StorageError: if the journal cannot be read.
        """
        if stream.clock is not None:
            stream.clock.bank.left = self._ledger.bank_left(stream.run.run_id)
