"""The journal of a process that is measured: what goes through it is counted."""

import time
from collections.abc import Callable, Collection, Sequence

from sqlalchemy.engine import Connection

from server.runs.database import Database
from server.runs.journal import Journal
from server.runs.meter import Meter, Stage
from server.runs.records import RUNNING, Batch, Claim, Run


class CountedJournal(Journal):
    """As `Journal`.

    Args:
        database: where it is kept.
        meter: is told.
    """

    def __init__(self, database: Database, meter: Meter) -> None:
        super().__init__(database)
        self._meter = meter

    def create(
        self, run: Run, episode_ids: Sequence[str], admit: Callable[[Connection], None] = lambda _: None
    ) -> None:
        """As the journal's."""
        super().create(run, episode_ids, admit)
        self._meter.run_created()

    def set_state(self, run_id: str, state: str) -> None:
        """As the journal's."""
        before = self.run(run_id).state
        super().set_state(run_id, state)
        if before == RUNNING:
            self._meter.run_ended(state)

    def claim(
        self, run_id: str, claims: Sequence[Claim], player: str, worker: str, *, reoffered: Collection[str] = ()
    ) -> list[Claim]:
        """As the journal's."""
        won = super().claim(run_id, claims, player, worker, reoffered=reoffered)
        if again := sum(claim.episode_id in reoffered for claim in won):
            self._meter.reoffered(again)
        return won

    def commit(self, batch: Batch) -> None:
        """As the journal's."""
        if not (batch.steps or batch.endings or batch.charges):
            return
        started = time.perf_counter()
        super().commit(batch)
        self._meter.took(Stage.COMMIT, time.perf_counter() - started)
        if batch.steps:
            self._meter.stepped(len(batch.steps))
        for ending in batch.endings:
            self._meter.episode_ended(ending.cause)
