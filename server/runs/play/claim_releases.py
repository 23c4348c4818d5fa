"""Queue of claim releases of closed streams, retried in order until they are written to the journal."""

from arramon_server.runs.play.stream import Stream
from arramon_server.runs.storage.journal import Journal
from arramon_server.runs.storage.records import CommitBatch


class PendingReleases:
    """The releases of one process that are not written to the journal yet. Not thread-safe.

    Args:
        journal: journal to write them to.
    """

    def __init__(self, journal: Journal) -> None:
        self._journal = journal
        self._unwritten: list[_Release] = []

    def add(self, stream: Stream, now: float) -> None:
        """Queue the release of all episodes of a stream that has just closed.

        Args:
            stream: stream as it was when it closed.
            now: current time of its clock, in seconds.
        """
        self._unwritten.append(_Release(stream, now))

    def write(self) -> None:
        """Write all queued releases.

        Raises:
            StorageError: if the journal cannot be written. What was not written stays queued.
        """
        while self._unwritten:
            release = self._unwritten[0]
            self._journal.release(release.run_id, release.fences, release.waits)
            self._journal.commit(release.batch)
            self._unwritten.pop(0)


class _Release:
    """The release of one stream's episodes, with overdue time that is not charged yet."""

    def __init__(self, stream: Stream, now: float) -> None:
        self.run_id = stream.run.run_id
        self.fences = {episode_id: session.fence for episode_id, session in stream.sessions.items()}
        self.fences |= {episode_id: assigned.claim.fence for episode_id, assigned in stream.assigned.items()}
        self.waits: dict[str, tuple[int, float | None]] = {}
        self.batch = CommitBatch()
        if stream.clock is not None:
            stream.clock.charge(now)
            self.batch.charge(self.run_id, stream.clock.take_charges())
            self.waits = stream.clock.waiting_times()
