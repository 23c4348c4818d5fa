"""Clock banks, last activity and server faults of runs."""

from collections.abc import Iterable, Sequence

import sqlalchemy as sa

from server.runs.storage import tables
from server.runs.storage.database import Database
from server.runs.storage.journal import run_of
from server.runs.storage.records import ENDED, RUNNING, Claim, Run
from server.runs.storage.service_clock import service_time

ABANDONED_SECONDS = 60.0
"""Seconds by which a run's time must be exceeded before it is closed: a process that stalls notes nothing meanwhile."""


class RunActivity:
    """Banks, activity and fault counts of all runs.

    Args:
        database: database of the journal.
    """

    def __init__(self, database: Database) -> None:
        self._database = database

    def bank_left(self, run_id: str) -> float:
        """Return the seconds left in a run's bank; 0 without a bank."""
        rows = self._database.read(sa.select(tables.runs.c.bank_left).where(tables.runs.c.run_id == run_id))
        return float(rows[0].bank_left or 0.0)

    def count_fault(self, run_id: str, claim: Claim, most: int) -> int:
        """Count a fault of the server on an episode, release the episode, and return its number of faults.

        Args:
            run_id: id of the run.
            claim: claim under which the episode was open; if it is no longer held, nothing is counted.
            most: number of faults at which the episode is not offered again; below it, a reoffer is counted too.
        """
        c = tables.episodes.c
        held = sa.and_(c.run_id == run_id, c.episode_id == claim.episode_id, c.epoch == claim.epoch, c.state != ENDED)
        values = {
            "faults": c.faults + 1,
            "reoffers": c.reoffers + sa.case((c.faults + 1 < most, 1), else_=0),
            "worker": None,
            "left": service_time(self._database.now),
            "sent": None,
        }
        with self._database.write() as connection:
            connection.execute(tables.episodes.update().where(held).values(values))
            return connection.execute(sa.select(c.faults).where(held)).scalar() or 0

    def note_active(self, run_ids: Iterable[str]) -> None:
        """Record that streams of these runs are open now. The time of a run that was never noted begins now, too."""
        c = tables.runs.c
        unnoted = sa.and_(c.state == RUNNING, c.active_at.is_(None))
        for condition in (unnoted, *(c.run_id == run_id for run_id in sorted(run_ids))):
            values = {"active_at": service_time(self._database.now)}
            with self._database.write() as connection:
                connection.execute(tables.runs.update().where(condition).values(values))

    def abandoned(self, data_hashes: Sequence[str]) -> Run | None:
        """Return a run on one of these data sets without a stream for longer than its bank; None if there is none."""
        c, now = tables.runs.c, service_time(self._database.now)
        is_over = now - c.active_at > c.step_seconds + c.bank_left + ABANDONED_SECONDS
        running = sa.and_(c.state == RUNNING, c.data_hash.in_(data_hashes))
        rows = self._database.read(sa.select(tables.runs).where(running, is_over).limit(1))
        return run_of(rows[0]) if rows else None
