"""Closes a run before its end: everything that is left of it is forfeited, and scored as it stands."""

from server.runs import causes
from server.runs.endings import ending, unplayed
from server.runs.faults import EpisodeFault, contained
from server.runs.journal import Journal
from server.runs.opening import Opening
from server.runs.records import PENDING, Batch, Claim, Ending, Run

CHUNK = 64
"""Episodes that are ended at once which nobody has begun; other streams are served between two such."""

OPEN_CHUNK = 1
"""And of those that are open: what was played of each is played again, hundreds of steps."""


class Closing:
    """Closes runs.

    Args:
        journal: where they are kept.
        opening: plays their open episodes again, to score them.
        worker: this process.
    """

    def __init__(self, journal: Journal, opening: Opening, worker: str) -> None:
        self._journal = journal
        self._opening = opening
        self._worker = worker

    def forfeit_some(self, run: Run, note: str) -> bool:
        """Ends some of what is left of a run; returns whether there was anything.

        Whoever plays these episodes loses them first, and cannot write any more. What ended in between stays as it is.
        """
        claims = self._journal.open_claims(run.run_id, OPEN_CHUNK) or self._journal.pending(run.run_id, CHUNK)
        won = self._journal.claim(run.run_id, claims, "", self._worker) if claims else []
        self._journal.commit(Batch(endings=[self._ending(run, claim, note) for claim in won]))
        return bool(claims)

    def _ending(self, run: Run, claim: Claim, note: str) -> Ending:
        if claim.state == PENDING:
            return unplayed(run, self._opening.episode(run, claim), claim, causes.FORFEITED, note)
        try:
            with contained(run, claim, "scoring"):
                return ending(run, self._opening.played(run, claim), causes.FORFEITED, note)
        except EpisodeFault:
            return unplayed(run, self._opening.episode(run, claim), claim, causes.SERVER_FAULT, note)
