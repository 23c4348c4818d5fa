"""Clock banks, absences, last activity and server faults of runs."""

from collections.abc import Iterable, Sequence

import sqlalchemy as sa

from server.runs.storage import tables
from server.runs.storage.database import Database
from server.runs.storage.journal import run_of
from server.runs.storage.records import AWAY_SECONDS, ENDED, RUNNING, Claim, Run

EXCUSE_SECONDS = 86_400.0
"""Minimum time before an idle run is closed once the server is back after a downtime."""

EXCUSED_AFTER = 60.0
"""Seconds without a heartbeat of any process after which the server counts as having been down."""


class RunActivity:
    """Banks, absences, activity and fault counts of all runs.

    Args:
        database: database of the journal.
    """

    def __init__(self, database: Database) -> None:
        self._database = database

    def bank_left(self, run_id: str) -> float:
        """Return the seconds left in a run's bank; 0 without a bank."""
        rows = self._database.read(sa.select(tables.runs.c.bank_left).where(tables.runs.c.run_id == run_id))
        return float(rows[0].bank_left or 0.0)

    def has_steps(self, run_id: str) -> bool:
        """Return whether a run has any recorded step."""
        query = sa.select(tables.steps.c.step).where(tables.steps.c.run_id == run_id).limit(1)
        return bool(self._database.read(query))

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
            "left": self._database.now,
        }
        with self._database.write() as connection:
            connection.execute(tables.episodes.update().where(held).values(values))
            return connection.execute(sa.select(c.faults).where(held)).scalar() or 0

    def add_absence(self, run_id: str, seconds: float) -> float:
        """Charge the last `seconds` to a run as absence of its players; return the remaining allowance, in seconds.

        Simultaneous absences of several streams count once. The allowance is negative once it is used up.
        """
        c, now = tables.runs.c, self._database.now
        began = now - seconds
        since = sa.case((c.away_until > began, c.away_until), else_=began)
        values = {"away": c.away + sa.case((since < now, now - since), else_=0.0), "away_until": now}
        with self._database.write() as connection:
            connection.execute(tables.runs.update().where(c.run_id == run_id).values(values))
        return self.away_left(run_id)

    def away_left(self, run_id: str) -> float:
        """Return what is left of a run's `AWAY_SECONDS`, in seconds; negative once they are used up."""
        rows = self._database.read(sa.select(tables.runs.c.away).where(tables.runs.c.run_id == run_id))
        return AWAY_SECONDS - float(rows[0].away)

    def note_active(self, run_ids: Iterable[str]) -> None:
        """Record that runs are being played now."""
        c = tables.runs.c
        for run_id in sorted(run_ids):
            with self._database.write() as connection:
                connection.execute(tables.runs.update().where(c.run_id == run_id).values(active_at=self._database.now))

    def idle(self, seconds: float, data_hashes: Sequence[str]) -> Run | None:
        """Return a run on one of these data sets that was not played for more than `seconds`; None if there is none."""
        c = tables.runs.c
        idle = sa.and_(c.state == RUNNING, c.data_hash.in_(data_hashes), self._database.now - _last_active() > seconds)
        rows = self._database.read(sa.select(tables.runs).where(idle).limit(1))
        return run_of(rows[0]) if rows else None

    def excuse_idle(self, seconds: float) -> None:
        """Extend the time of idle runs after a downtime of the server, so that none is closed for a day.

        This has an effect only in the first process to start: participants could not play while the server was down.

        Args:
            seconds: time after which an idle run is closed.
        """
        c, now = tables.runs.c, self._database.now
        since = now - seconds + min(seconds, EXCUSE_SECONDS)
        is_first = ~sa.exists().where(tables.workers.c.seen > now - EXCUSED_AFTER)
        with self._database.write() as connection:
            connection.execute(
                tables.runs.update().where(c.state == RUNNING, _last_active() < since, is_first).values(active_at=since)
            )


def _last_active() -> sa.ColumnElement[float]:
    """Return the time at which a run was last played, or else created, in seconds since 1970."""
    c = tables.runs.c
    return sa.func.coalesce(c.active_at, sa.extract("epoch", c.created_at))
