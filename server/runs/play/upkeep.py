"""Upkeep of one worker process, once a second: heartbeat, pending releases, absences, and runs that lie idle."""

import time
from collections.abc import Callable, Sequence

from server.runs.play.absences import Absences
from server.runs.play.releases import PendingReleases
from server.runs.play.stream import Stream
from server.runs.storage.journal import Journal
from server.runs.storage.records import Run
from server.runs.storage.run_activity import RunActivity

SWEEP_SECONDS = 1.0
"""Time between two rounds of upkeep."""

ACTIVE_SECONDS = 60.0
"""Longest time between two notes that a run is being played, and between two looks for an idle run."""


class Upkeep:
    """The periodic work of one worker process. For use from one thread.

    Args:
        journal: receives heartbeats and releases.
        activity: knows when runs were last played.
        data_hashes: of the splits that this process serves.
        worker: id of this process.
        address: of this process alone; empty if it has none.
        idle_seconds: time after which an unplayed run is closed; 0 for never.
        now: clock of play, in seconds.

    Attributes:
        releases: of streams that have left.
        absences: of the players of this process.
    """

    def __init__(
        self,
        journal: Journal,
        activity: RunActivity,
        data_hashes: Sequence[str],
        *,
        worker: str,
        address: str,
        idle_seconds: float,
        now: Callable[[], float],
    ) -> None:
        self._journal = journal
        self._activity = activity
        self._data = data_hashes
        self._worker = worker
        self._address = address
        self._idle_seconds = idle_seconds
        self._now = now
        self._next_note = 0.0
        self.releases = PendingReleases(journal)
        self.absences = Absences(journal, activity, now)

    def start(self) -> None:
        """Register this process.

        Raises:
            StorageError: if the journal cannot be written.
        """
        if self._idle_seconds:
            self._activity.excuse_idle(self._idle_seconds)
        self._journal.beat(self._worker, self._address)

    def sweep(self, streams: Sequence[Stream]) -> Run | None:
        """Do one round of upkeep.

        Args:
            streams: that are open at this process.

        Returns:
            A run that has been idle for too long and has to be closed, if there is one.

        Raises:
            StorageError: if the journal cannot be read or written; nothing is lost, the next round tries again.
        """
        self._journal.beat(self._worker, self._address)
        self.releases.write()
        self.absences.count()
        if not self._idle_seconds or time.monotonic() < self._next_note:
            return None
        self._next_note = time.monotonic() + min(ACTIVE_SECONDS, self._idle_seconds / 4)
        self._activity.note_active({stream.run.run_id for stream in streams})
        run = self._activity.idle(self._idle_seconds, self._data)
        if run is not None:
            self._next_note = 0.0  # There may be more of them: look again in the next round.
        return run

    def leave(self, stream: Stream) -> None:
        """Note that a stream has left: its episodes are free, and the time of its absence runs."""
        epochs = self.releases.add(stream, self._now())
        if stream.clock is not None:
            self.absences.begin(stream.run.run_id, epochs)
