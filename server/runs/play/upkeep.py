"""Periodic work of one server process, once a second: heartbeat, pending releases, and abandoned runs."""

import logging
import time
from collections.abc import Sequence

from arramon_server.runs.play.claim_releases import PendingReleases
from arramon_server.runs.play.stream import Stream
from arramon_server.runs.storage.journal import Journal
from arramon_server.runs.storage.records import LEASE, Run
from arramon_server.runs.storage.run_activity import RunActivity

SWEEP_SECONDS = 1.0
"""Time between two rounds of upkeep."""

ACTIVE_SECONDS = 10.0
"""Interval at which runs with streams are recorded as active, and abandoned runs are searched for."""

_log = logging.getLogger(__name__)


class Upkeep:
    """The periodic work of one server process. Not thread-safe.

    Args:
        journal: receives heartbeats and releases.
        activity: knows when runs were last played.
        data_hashes: data hashes of the served splits.
        worker: id of this process.
        address: address of this process alone; empty if it has none.

    Attributes:
        releases: claim releases of streams that have left.
    """

    def __init__(
        self, journal: Journal, activity: RunActivity, data_hashes: Sequence[str], *, worker: str, address: str
    ) -> None:
        self._journal = journal
        self._activity = activity
        self._data = data_hashes
        self._worker = worker
        self._address = address
        self._next_note, self._beaten_at = 0.0, time.monotonic()
        self.releases = PendingReleases(journal)

    def start(self) -> None:
        """Register this process.

        Raises:
            StorageError: if the journal cannot be written.
        """
        self._journal.beat(self._worker, self._address)
        self._beaten_at = time.monotonic()

    def sweep(self, streams: Sequence[Stream]) -> Run | None:
        """Do one round of upkeep.

        Args:
            streams: open streams of this process.

        Returns:
            An abandoned run to close, or None.

        Raises:
            StorageError: if the journal cannot be read or written; nothing is lost, the next round tries again.
        """
        self._journal.beat(self._worker, self._address)
        self._note_beat()
        self.releases.write()
        if time.monotonic() < self._next_note:
            return None
        self._next_note = time.monotonic() + ACTIVE_SECONDS
        self._activity.note_active({stream.run.run_id for stream in streams})
        run = self._activity.abandoned(self._data)
        if run is not None:
            self._next_note = 0.0  # There may be more of them: look again in the next round.
        return run

    def _note_beat(self) -> None:
        """Note a heartbeat; warn if it is so late that other processes may have considered this one dead."""
        before, self._beaten_at = self._beaten_at, time.monotonic()
        if self._beaten_at - before > LEASE:
            seconds = self._beaten_at - before
            _log.warning("no heartbeat for %.0f seconds: other processes may have taken over episodes", seconds)
