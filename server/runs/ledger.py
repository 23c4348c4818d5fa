"""What the journal keeps of a run beside its play: its bank, when it was last active, and the server's faults."""

from collections.abc import Iterable, Sequence

import sqlalchemy as sa

from server.runs import tables
from server.runs.clocks import AWAY_SECONDS
from server.runs.database import Database
from server.runs.journal import run_of
from server.runs.records import ENDED, RUNNING, Claim, Run

EXCUSE_SECONDS = 86_400.0
"""What runs have at least after the server was away, before they are closed for lying idle."""

EXCUSED_AFTER = 60.0
"""Seconds without any process from which on it was away."""


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

    def absent(self, run_id: str, seconds: float) -> float:
        """A run's episodes waited for the last so many seconds for who had left; returns what is left to be away.

        What several streams were away for at the same time counts once. It is less than nothing once it is used up.
        """
        c, now = tables.runs.c, self._database.now
        began = now - seconds
        since = sa.case((c.away_until > began, c.away_until), else_=began)
        values = {"away": c.away + sa.case((since < now, now - since), else_=0.0), "away_until": now}
        with self._database.write() as connection:
            connection.execute(tables.runs.update().where(c.run_id == run_id).values(values))
        return self.away_left(run_id)

    def away_left(self, run_id: str) -> float:
        """What is left of `AWAY_SECONDS` of a run; less than nothing once it is used up."""
        rows = self._database.read(sa.select(tables.runs.c.away).where(tables.runs.c.run_id == run_id))
        return AWAY_SECONDS - float(rows[0].away)

    def note_active(self, run_ids: Iterable[str]) -> None:
        """These runs are being played."""
        c = tables.runs.c
        for run_id in sorted(run_ids):
            with self._database.write() as connection:
                connection.execute(tables.runs.update().where(c.run_id == run_id).values(active_at=self._database.now))

    def idle(self, seconds: float, data_hashes: Sequence[str]) -> Run | None:
        """A run on this data that nobody has played for so long, if there is one."""
        c = tables.runs.c
        idle = sa.and_(c.state == RUNNING, c.data_hash.in_(data_hashes), self._database.now - _last_active() > seconds)
        rows = self._database.read(sa.select(tables.runs).where(idle).limit(1))
        return run_of(rows[0]) if rows else None

    def excuse_idle(self, seconds: float) -> None:
        """The first process of a server starts: whoever could not play without it has a day yet before runs are closed.

        Args:
            seconds: for which a run may lie idle.
        """
        c, now = tables.runs.c, self._database.now
        since = now - seconds + min(seconds, EXCUSE_SECONDS)
        is_first = ~sa.exists().where(tables.workers.c.seen > now - EXCUSED_AFTER)
        with self._database.write() as connection:
            connection.execute(
                tables.runs.update().where(c.state == RUNNING, _last_active() < since, is_first).values(active_at=since)
            )


def _last_active() -> sa.ColumnElement[float]:
    """When a run was last played, or created; in seconds since 1970."""
    c = tables.runs.c
    return sa.func.coalesce(c.active_at, sa.extract("epoch", c.created_at))
