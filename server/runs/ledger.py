"""What the journal keeps of a run beside its play: its bank, when it was last active, and the server's faults."""

from collections.abc import Iterable

import sqlalchemy as sa

from server.runs import tables
from server.runs.database import Database
from server.runs.journal import run_of
from server.runs.records import ENDED, RUNNING, Claim, Run


class Ledger:
    """Of all runs.

    Args:
        database: of the journal.
    """

    def __init__(self, database: Database) -> None:
        self._database = database

    def bank_left(self, run_id: str) -> float:
        """Seconds in a run's bank."""
        rows = self._database.read(sa.select(tables.runs.c.bank_left).where(tables.runs.c.run_id == run_id))
        return float(rows[0].bank_left or 0.0)

    def has_steps(self, run_id: str) -> bool:
        """Whether a run has had an answer."""
        query = sa.select(tables.steps.c.step).where(tables.steps.c.run_id == run_id).limit(1)
        return bool(self._database.read(query))

    def count_fault(self, run_id: str, claim: Claim, most: int) -> int:
        """The server broke down over an episode: lets go of it, and returns how often that has happened.

        Args:
            run_id: of the run.
            claim: under which it was open; nothing is counted where that is not held any more.
            most: faults; before that many the episode is offered again, and that is counted.
        """
        c = tables.episodes.c
        held = sa.and_(c.run_id == run_id, c.episode_id == claim.episode_id, c.epoch == claim.epoch, c.state != ENDED)
        values = {
            "faults": c.faults + 1,
            "reoffers": c.reoffers + sa.case((c.faults + 1 < most, 1), else_=0),
            "worker": None,
            "left": self._database.now,
        }
        with self._database.write() as connection:
            connection.execute(tables.episodes.update().where(held).values(values))
            return connection.execute(sa.select(c.faults).where(held)).scalar() or 0

    def note_active(self, run_ids: Iterable[str]) -> None:
        """These runs are being played."""
        c = tables.runs.c
        for run_id in sorted(run_ids):
            with self._database.write() as connection:
                connection.execute(tables.runs.update().where(c.run_id == run_id).values(active_at=self._database.now))

    def idle(self, seconds: float) -> Run | None:
        """A run that nobody has played for so long, if there is one."""
        c = tables.runs.c
        created = sa.extract("epoch", c.created_at)
        idle = self._database.now - sa.func.coalesce(c.active_at, created) > seconds
        rows = self._database.read(sa.select(tables.runs).where(c.state == RUNNING, idle).limit(1))
        return run_of(rows[0]) if rows else None
