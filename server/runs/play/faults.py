"""Server faults while an episode is played: contained to that episode, retried, and counted.

A fault is an exception that no client can cause: a world that cannot be built, a step or a frame that fails. It never
counts against the participant: the episode is offered again, up to `MAX_FAULTS` times, and then ends by SERVER_FAULT.
"""

import logging
from collections import deque
from types import TracebackType

from arramon_server.errors import ArraMonError
from arramon_server.runs.play.events import EpisodeEnded, Observed
from arramon_server.runs.play.session import ending_of, unplayed_ending
from arramon_server.runs.play.session_loader import SessionLoader
from arramon_server.runs.play.stream import Stream
from arramon_server.runs.storage import causes
from arramon_server.runs.storage.journal import Journal
from arramon_server.runs.storage.records import Claim, CommitBatch, EpisodeEnding, Run
from arramon_server.runs.storage.run_activity import RunActivity

MAX_FAULTS = 3
"""Faults after which an episode is not offered again."""

_log = logging.getLogger(__name__)


class EpisodeFault(Exception):
    """The server failed on one episode.

    Args:
        claim: claim of the episode.
    """

    def __init__(self, claim: Claim) -> None:
        super().__init__(f"the server failed on episode {claim.episode_id!r}")
        self.claim = claim


class fault_boundary:  # noqa: N801 - a class rather than a generator, as every step enters it
    """Context manager that logs any unexpected exception of its block and raises `EpisodeFault` instead.

    This is the one place that catches all exceptions. `ArraMonError` passes, and so does what ends the process.

    Args:
        run: run in play.
        claim: claim of its episode.
        doing: the operation, as a participle for the log.

    Raises:
        EpisodeFault: on leaving the block.
    """

    __slots__ = ("_claim", "_doing", "_run")

    def __init__(self, run: Run, claim: Claim, doing: str) -> None:
        self._run, self._claim, self._doing = run, claim, doing

    def __enter__(self) -> None:
        """Enter the block."""

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None) -> None:
        """Leave the block."""
        if error is None or not isinstance(error, Exception) or isinstance(error, ArraMonError | EpisodeFault):
            return
        message = "a fault while %s episode %s of run %s"
        run_id, episode_id = self._run.run_id, self._claim.episode_id
        fields = {"run_id": run_id, "episode_id": episode_id}
        _log.error(message, self._doing, episode_id, run_id, exc_info=error, extra=fields)
        raise EpisodeFault(self._claim) from error


class FaultHandler:
    """Decides whether a faulty episode is offered again or ends.

    Args:
        journal: receives the end of an episode.
        activity: counts the faults.
        loader: replays episodes, to score them.
    """

    def __init__(self, journal: Journal, activity: RunActivity, loader: SessionLoader) -> None:
        self._journal = journal
        self._activity = activity
        self._loader = loader

    def handle(self, stream: Stream, claim: Claim) -> None:
        """Remove an episode from its stream, to be offered again later; after `MAX_FAULTS` faults, end it.

        Raises:
            ArraMonError: if the journal cannot be written, or another process has the episode now.
        """
        run = stream.run
        stream.drop(claim.episode_id)
        mine = [e for e in stream.outbox if not (isinstance(e, Observed) and e.episode.episode_id == claim.episode_id)]
        stream.outbox = deque(mine)
        if self._activity.count_fault(run.run_id, claim, MAX_FAULTS) < MAX_FAULTS:
            return
        self._journal.commit(CommitBatch(endings=[self._ending(run, claim)]))
        ended = EpisodeEnded(claim.episode_id, causes.SERVER_FAULT, self._journal.count_ended(run.run_id))
        stream.note_end(claim.episode_id)
        stream.outbox.append(ended)

    def _ending(self, run: Run, claim: Claim) -> EpisodeEnding:
        """Return the end of an episode, scored as far as it can be replayed."""
        note = f"the server failed on it {MAX_FAULTS} times"
        try:
            with fault_boundary(run, claim, "scoring"):
                return ending_of(run, self._loader.replay(run, claim), causes.SERVER_FAULT, note)
        except EpisodeFault:
            return unplayed_ending(run, self._loader.episode(run, claim), claim, causes.SERVER_FAULT, note)
