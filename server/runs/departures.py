"""What is to be written of streams that have left: kept until the journal has taken it, in their order."""

import time
from collections.abc import Mapping

from server.runs.journal import Journal
from server.runs.records import Batch
from server.runs.stream import Stream


class Departures:
    """The streams of one process that have left. It belongs to one thread.

    Args:
        journal: where it is written that their episodes are free.
    """

    def __init__(self, journal: Journal) -> None:
        self._journal = journal
        self._unwritten: list[_Departure] = []

    def add(self, stream: Stream, now: float) -> Mapping[str, int]:
        """A stream has left just now.

        Args:
            stream: as it left.
            now: by its clock.

        Returns:
            The epochs of the claims under which it held its episodes.
        """
        departure = _Departure(stream, now)
        self._unwritten.append(departure)
        return departure.epochs

    def write(self) -> None:
        """Writes what has not been written yet.

        Raises:
            StorageError: if the journal cannot be written. The rest is kept.
        """
        while self._unwritten:
            departure = self._unwritten[0]
            ago = time.monotonic() - departure.left_at
            self._journal.release(departure.run_id, departure.epochs, ago=ago, waited=departure.waited)
            self._journal.commit(departure.batch)
            self._unwritten.pop(0)


class _Departure:
    """What is to be written of one stream."""

    def __init__(self, stream: Stream, now: float) -> None:
        self.run_id = stream.run.run_id
        self.left_at = time.monotonic()
        self.epochs = {episode_id: session.epoch for episode_id, session in stream.sessions.items()}
        self.epochs |= {episode_id: coming.claim.epoch for episode_id, coming in stream.coming.items()}
        self.waited = {episode_id: coming.claim.waited for episode_id, coming in stream.coming.items()}
        self.batch = Batch()
        if stream.clock is not None:
            stream.clock.charge(now)
            self.batch.charge(self.run_id, stream.clock.settle())
            self.waited |= stream.clock.waited()
