"""Forfeits the remaining episodes of a cancelled or abandoned run: each is scored as far as it was played."""

from datetime import datetime

from arramon_server.runs.play.faults import EpisodeFault, fault_boundary
from arramon_server.runs.play.session import ending_of, lost_ending, unplayed_ending
from arramon_server.runs.play.session_loader import SessionLoader
from arramon_server.runs.storage import causes
from arramon_server.runs.storage.journal import Journal
from arramon_server.runs.storage.records import CANCELLED, CLOSER, PENDING, Claim, CommitBatch, EpisodeEnding, Run

CHUNK = 64
"""Number of episodes without steps that are ended at once; other streams are served between two chunks."""

OPEN_CHUNK = 1
"""The same for open episodes, which are first replayed, over hundreds of steps each."""


class Forfeits:
    """Ends the remaining episodes of runs.

    Args:
        journal: stores the claims.
        loader: replays open episodes, to score them.
        worker: id of this process.
    """

    def __init__(self, journal: Journal, loader: SessionLoader, worker: str) -> None:
        self._journal = journal
        self._loader = loader
        self._worker = worker

    def cancel_some(self, run: Run, note: str, now: datetime | None = None) -> bool:
        """End some episodes as `forfeit_some` does; the transaction that ends the last one also cancels the run.

        Args:
            run: run to cancel.
            note: kept with each ending.
            now: the time; None for that of the journal.
        """
        ended_at = max(now or self._journal.time(), run.created_at)
        return self._forfeit_some(run, note, {run.run_id: (CANCELLED, ended_at)})

    def forfeit_some(self, run: Run, note: str) -> bool:
        """End some of a run's remaining episodes, and return whether there were any.

        They are claimed first, so that their players cannot write any more; those that end in the meantime stay as
        they are. If the run's data is gone, its episodes cannot be played any more and end by the server's fault.
        """
        return self._forfeit_some(run, note, {})

    def _forfeit_some(self, run: Run, note: str, over: dict[str, tuple[str, datetime]]) -> bool:
        claims = self._journal.open_claims(run.run_id, OPEN_CHUNK) or self._journal.pending(run.run_id, CHUNK)
        won = self._journal.claim(run.run_id, claims, CLOSER, self._worker) if claims else []
        self._journal.commit(CommitBatch(endings=[self._ending(run, claim, note) for claim in won], over=over))
        return bool(claims)

    def _ending(self, run: Run, claim: Claim, note: str) -> EpisodeEnding:
        if not self._loader.has_data(run):
            return lost_ending(run, claim, note)
        if claim.state == PENDING:
            return unplayed_ending(run, self._loader.episode(run, claim), claim, causes.FORFEITED, note)
        try:
            with fault_boundary(run, claim, "scoring"):
                return ending_of(run, self._loader.replay(run, claim), causes.FORFEITED, note)
        except EpisodeFault:
            return unplayed_ending(run, self._loader.episode(run, claim), claim, causes.SERVER_FAULT, note)
