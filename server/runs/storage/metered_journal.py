"""A journal that reports its operations to a meter."""

import time
from collections.abc import Callable, Collection, Sequence
from datetime import datetime

from sqlalchemy.engine import Connection

from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.journal import Journal
from arramon_server.runs.storage.meter import Meter, Stage
from arramon_server.runs.storage.records import RUNNING, Claim, CommitBatch, Run


class MeteredJournal(Journal):
    """A `Journal` that reports created and ended runs, claims, steps and commit times to a meter.

    Args:
        database: storage of the journal.
        meter: receives the measurements.
    """

    def __init__(self, database: Database, meter: Meter) -> None:
        super().__init__(database)
        self._meter = meter

    def create(
        self, run: Run, episode_ids: Sequence[str], admit: Callable[[Connection], None] = lambda _: None
    ) -> None:
        """Create a run as `Journal` does, and count it."""
        super().create(run, episode_ids, admit)
        self._meter.run_created()

    def set_state(self, run_id: str, state: str, ended_at: datetime | None = None) -> None:
        """Set the state of a run as `Journal` does, and count the run if it ended."""
        before = self.run(run_id).state
        super().set_state(run_id, state, ended_at)
        if before == RUNNING:
            self._meter.run_ended(state)

    def claim(
        self, run_id: str, claims: Sequence[Claim], player: str, worker: str, *, reoffered: Collection[str] = ()
    ) -> list[Claim]:
        """Claim episodes as `Journal` does, and count those that are offered again."""
        won = super().claim(run_id, claims, player, worker, reoffered=reoffered)
        if again := sum(claim.episode_id in reoffered for claim in won):
            self._meter.count_reoffers(again)
        return won

    def commit(self, batch: CommitBatch) -> None:
        """Commit a batch as `Journal` does, and count its steps and endings, and time the commit."""
        if not (batch.steps or batch.endings or batch.charges):
            return
        started = time.perf_counter()
        super().commit(batch)
        self._meter.record_duration(Stage.COMMIT, time.perf_counter() - started)
        if batch.steps:
            self._meter.count_steps(len(batch.steps))
        for ending in batch.endings:
            self._meter.episode_ended(ending.cause)
        for run_id, (state, _) in batch.over.items():
            if self.run(run_id).state == state:
                self._meter.run_ended(state)
