"""Time banks, last activity and server faults of runs; finds abandoned runs."""

from collections.abc import Iterable, Sequence

import sqlalchemy as sa

from arramon_server.runs.storage import tables
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.journal import run_of
from arramon_server.runs.storage.records import CLOSER, ENDED, RUNNING, Claim, Run
from arramon_server.runs.storage.service_clock import service_time

ABANDONED_SECONDS = 60.0
"""Grace period in seconds before an abandoned run is closed: a process that stalls does not record its activity."""

UNPLAYED_MINUTES = 15
"""Minutes until an anonymous run that was never played is closed, on servers where all strangers share one limit."""


class RunActivity:
    """Banks, activity and fault counts of all runs, and the search for abandoned ones.

    Args:
        database: database of the journal.
        close_unplayed: whether anonymous runs that were never played count as abandoned after UNPLAYED_MINUTES.
    """

    def __init__(self, database: Database, *, close_unplayed: bool = False) -> None:
        self._database = database
        self._close_unplayed = close_unplayed

    def bank_left(self, run_id: str) -> float:
        """Return the seconds left in a run's bank; 0 without a bank."""
        rows = self._database.read(sa.select(tables.runs.c.bank_left).where(tables.runs.c.run_id == run_id))
        return float(rows[0].bank_left or 0.0)

    def count_fault(self, run_id: str, claim: Claim, max_faults: int) -> int:
        """Count a fault of the server on an episode, release the episode, and return its number of faults.

        Args:
            run_id: id of the run.
            claim: claim under which the episode was open; if it is no longer held, nothing is counted.
            max_faults: number of faults at which the episode is not offered again; below it, a reoffer is counted too.
        """
        c = tables.episodes.c
        held = sa.and_(c.run_id == run_id, c.episode_id == claim.episode_id, c.epoch == claim.fence, c.state != ENDED)
        values = {
            "faults": c.faults + 1,
            "reoffers": c.reoffers + sa.case((c.faults + 1 < max_faults, 1), else_=0),
            "worker": None,
            "left": service_time(self._database.now),
            "sent": None,
        }
        with self._database.write() as connection:
            connection.execute(tables.episodes.update().where(held).values(values))
            return connection.execute(sa.select(c.faults).where(held)).scalar() or 0

    def note_active(self, run_ids: Iterable[str]) -> None:
        """Record that streams of these runs are open now, and start the absence of runs that were never recorded."""
        c = tables.runs.c
        unnoted = sa.and_(c.state == RUNNING, c.active_at.is_(None))
        for condition in (unnoted, *(c.run_id == run_id for run_id in sorted(run_ids))):
            values = {"active_at": service_time(self._database.now)}
            with self._database.write() as connection:
                connection.execute(tables.runs.update().where(condition).values(values))

    def abandoned(self, data_hashes: Sequence[str]) -> Run | None:
        """Return an abandoned run on one of these data sets; None if there is none.

        It had no stream for longer than its bank or, with `close_unplayed`, is anonymous and was never played.
        """
        c, now = tables.runs.c, service_time(self._database.now)
        is_over = now - c.active_at > c.step_seconds + c.bank_left + ABANDONED_SECONDS
        if self._close_unplayed:
            is_old = now - c.active_at > UNPLAYED_MINUTES * 60.0
            is_over |= sa.and_(c.account.is_(None), is_old, ~_was_played())
        running = sa.and_(c.state == RUNNING, c.data_hash.in_(data_hashes))
        rows = self._database.read(sa.select(tables.runs).where(running, is_over).limit(1))
        return run_of(rows[0]) if rows else None


def _was_played() -> sa.ColumnElement[bool]:
    """Return the SQL condition that a stream has claimed an episode of a run, rather than the closing of the run."""
    c = tables.episodes.c
    return sa.exists().where(c.run_id == tables.runs.c.run_id, c.player != CLOSER).correlate(tables.runs)
