"""What the server itself does wrong with an episode: kept to that episode, offered again, and after some times ended.

A fault is an exception that no client can cause: a world that cannot be built, a step or a drawing that breaks down.
The run is never charged for it: how often an episode was offered again is counted and public, and an episode that ends
by it says so.
"""

import logging
from collections import deque
from types import TracebackType

from server.errors import ArraMonError
from server.runs import causes
from server.runs.endings import ending, unplayed
from server.runs.events import EpisodeEnded, Observed
from server.runs.journal import Journal
from server.runs.ledger import Ledger
from server.runs.opening import Opening
from server.runs.records import Batch, Claim, Ending, Run
from server.runs.stream import Stream

MAX_FAULTS = 3
"""After so many an episode ends: what broke down three times will break down again."""

_log = logging.getLogger(__name__)


class EpisodeFault(Exception):
    """The server broke down over one episode.

    Args:
        claim: of the episode.
    """

    def __init__(self, claim: Claim) -> None:
        super().__init__(f"the server broke down over episode {claim.episode_id!r}")
        self.claim = claim


class contained:  # noqa: N801 - reads as `with contained(...)`; a class, as this is done with every step
    """Turns whatever breaks down in its block into the episode's fault, and logs it: the one place where all exceptions
    are caught. The server's own errors stay what they are, and an end of the process stays one.

    Args:
        run: that is played.
        claim: of its episode.
        doing: what is done to it, for the log.

    Raises:
        EpisodeFault: on leaving the block.
    """

    __slots__ = ("_claim", "_doing", "_run")

    def __init__(self, run: Run, claim: Claim, doing: str) -> None:
        self._run, self._claim, self._doing = run, claim, doing

    def __enter__(self) -> None:
        """Begins the block."""

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None) -> None:
        """Ends it."""
        if error is None or not isinstance(error, Exception) or isinstance(error, ArraMonError | EpisodeFault):
            return
        message = "a fault while %s episode %s of run %s"
        run_id, episode_id = self._run.run_id, self._claim.episode_id
        fields = {"run_id": run_id, "episode_id": episode_id}
        _log.error(message, self._doing, episode_id, run_id, exc_info=error, extra=fields)
        raise EpisodeFault(self._claim) from error


class Faults:
    """Decides what becomes of an episode after a fault.

    Args:
        journal: keeps what ends.
        ledger: counts them.
        opening: plays episodes again.
    """

    def __init__(self, journal: Journal, ledger: Ledger, opening: Opening) -> None:
        self._journal = journal
        self._ledger = ledger
        self._opening = opening

    def take(self, stream: Stream, claim: Claim) -> None:
        """Takes an episode from its stream: the next offer may bring it back, or it ends and the stream is told.

        Raises:
            ArraMonError: if the journal cannot be written, or another process has the episode now.
        """
        run = stream.run
        stream.drop(claim.episode_id)
        mine = [e for e in stream.told if not (isinstance(e, Observed) and e.episode.episode_id == claim.episode_id)]
        stream.told = deque(mine)
        if self._ledger.count_fault(run.run_id, claim, MAX_FAULTS) < MAX_FAULTS:
            return
        self._journal.commit(Batch(endings=[self._ending(run, claim)]))
        ended = EpisodeEnded(claim.episode_id, causes.SERVER_FAULT, self._journal.count_ended(run.run_id))
        stream.ended[claim.episode_id] = ended
        stream.told.append(ended)

    def _ending(self, run: Run, claim: Claim) -> Ending:
        """As far as it was played; where that itself cannot be told, nothing was."""
        note = f"the server broke down {MAX_FAULTS} times"
        try:
            with contained(run, claim, "scoring"):
                return ending(run, self._opening.played(run, claim), causes.SERVER_FAULT, note)
        except EpisodeFault:
            return unplayed(run, self._opening.episode(run, claim), claim, causes.SERVER_FAULT, note)
