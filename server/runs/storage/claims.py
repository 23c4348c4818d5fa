"""Claims of episodes by players: query, acquire and release them."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace

import sqlalchemy as sa
from sqlalchemy.engine import Connection

from arramon_server.runs.storage import tables
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.records import ENDED, OPEN, PENDING, Claim
from arramon_server.runs.storage.service_clock import service_time


class Claims:
    """Claims of the episodes of all runs. Thread-safe.

    Args:
        database: storage of the claims.
    """

    def __init__(self, database: Database) -> None:
        self._database = database

    def open_episodes(self, run_id: str) -> list[str]:
        """Return the ids of the episodes of a run that are being played, in playing order."""
        c = tables.episodes.c
        query = sa.select(c.episode_id).where(c.run_id == run_id, c.state == OPEN).order_by(c.ordinal)
        return [row.episode_id for row in self._database.read(query)]

    def open_claims(self, run_id: str, limit: int | None = None) -> list[Claim]:
        """Return the claims of a run's first `limit` open episodes, in playing order; None for all."""
        episodes, workers, now = tables.episodes, tables.workers, service_time(self._database.now)
        # A clock that jumped back leaves heartbeats in the future: the absolute value counts as their age.
        silent = sa.func.abs(self._database.now - workers.c.seen)
        query = (
            sa.select(
                episodes.c.episode_id,
                episodes.c.state,
                episodes.c.player,
                episodes.c.epoch,
                episodes.c.sent_step,
                workers.c.worker_id,
                sa.func.coalesce(silent, now - episodes.c.left, now).label("idle"),
                (now - episodes.c.sent).label("waited"),
            )
            .outerjoin_from(episodes, workers, episodes.c.worker == workers.c.worker_id)
            .where(episodes.c.run_id == run_id, episodes.c.state == OPEN)
            .order_by(episodes.c.ordinal)
            .limit(limit)
        )
        return [
            Claim(row.episode_id, row.state, row.player, row.epoch, row.worker_id, row.idle, row.sent_step, row.waited)
            for row in self._database.read(query)
        ]

    def pending(self, run_id: str, limit: int | None = None) -> list[Claim]:
        """Return the claims of a run's first `limit` pending episodes, in playing order; None for all."""
        table = tables.episodes
        query = (
            sa.select(table.c.episode_id, table.c.state, table.c.player, table.c.epoch)
            .where(table.c.run_id == run_id, table.c.state == PENDING)
            .order_by(table.c.ordinal)
            .limit(limit)
        )
        return [Claim(row.episode_id, row.state, row.player, row.epoch) for row in self._database.read(query)]

    def claim(
        self, run_id: str, claims: Sequence[Claim], player: str, worker: str, *, reoffered: Collection[str] = ()
    ) -> list[Claim]:
        """Claim episodes for a player and a worker, except those whose fences have changed; return the new claims.

        This charges absences of the run's players until now to its bank.

        Args:
            run_id: id of the run.
            claims: claims as they were read.
            player: player name of the stream.
            worker: id of this process.
            reoffered: ids of the episodes that are offered again because of a fault of the server.
        """
        c = tables.episodes.c

        def these(wanted: Iterable[Claim]) -> sa.ColumnElement[bool]:
            return sa.and_(c.run_id == run_id, c.episode_id.in_([claim.episode_id for claim in wanted]))

        with self._database.write() as connection:
            # The rows are locked as they are read: this waits for pending writes of other processes, and sees them.
            query = sa.select(c.episode_id, c.epoch).where(these(claims), c.state != ENDED).order_by(c.episode_id)
            rows = connection.execute(query.with_for_update(key_share=True))
            fences: dict[str, int] = {row.episode_id: row.epoch for row in rows}
            won = [claim for claim in claims if fences.get(claim.episode_id) == claim.fence]
            values = {
                "state": OPEN,
                "player": player,
                "epoch": c.epoch + 1,
                "worker": worker,
                "left": None,
            }
            again = [claim for claim in won if claim.episode_id in reoffered]
            if again:
                connection.execute(tables.episodes.update().where(these(again)).values(reoffers=c.reoffers + 1))
            if won:
                self._charge_absences(connection, run_id)
                connection.execute(tables.episodes.update().where(these(won)).values(values))
        return [replace(claim, fence=claim.fence + 1) for claim in won]

    def release(
        self, run_id: str, fences: Mapping[str, int], waits: Mapping[str, tuple[int, float | None]] | None = None
    ) -> None:
        """Release the open episodes that are still held under the given fences.

        The clock of a step keeps running from the time at which its observation was sent. An episode that another
        process has taken over keeps the earlier of the two times, so that changing the process gains no time.

        Args:
            run_id: id of the run.
            fences: fence of the claim, by episode.
            waits: by episode, the number of its present step, and the seconds since its observation was sent (None if
                it was not); an episode that was never opened is not in it, and keeps what was known.
        """
        c, now = tables.episodes.c, service_time(self._database.now)
        this = sa.and_(c.run_id == run_id, c.episode_id == sa.bindparam("id"))
        held = c.epoch == sa.bindparam("held")
        number, sent = sa.bindparam("number", type_=sa.Integer), now - sa.bindparam("ago", type_=sa.Float)
        is_newer = sa.or_(c.sent_step.is_(None), c.sent_step < number, sa.and_(c.sent_step == number, c.sent > sent))
        free = tables.episodes.update().where(this, held).values(worker=None, left=now)
        wait = tables.episodes.update().where(this, sa.or_(held, is_newer)).values(sent=sent, sent_step=number)
        order = sorted(fences.items())  # always the same, as in `commit`
        waits = waits or {}
        rows = [{"id": episode_id, "held": fence} for episode_id, fence in order]
        waiting = [
            {"id": episode_id, "held": fence, "number": waits[episode_id][0], "ago": waits[episode_id][1]}
            for episode_id, fence in order
            if episode_id in waits
        ]
        if not rows:
            return
        with self._database.write() as connection:
            connection.execute(free, rows)
            if waiting:
                connection.execute(wait, waiting)
            self._charge_absences(connection, run_id, charged_by_stream=list(waits))

    def _charge_absences(self, connection: Connection, run_id: str, charged_by_stream: Sequence[str] = ()) -> None:
        """Charge a run's bank for the time until now during which released episodes were overdue, each second once.

        Call it whenever episodes are claimed or released: in between, the set of waiting episodes does not change.

        Args:
            connection: connection in a transaction.
            run_id: id of the run.
            charged_by_stream: ids of the episodes whose time a stream has charged until now.
        """
        runs, c, now = tables.runs.c, tables.episodes.c, service_time(self._database.now)
        others = c.episode_id.not_in(charged_by_stream)
        waiting = sa.and_(c.run_id == run_id, c.state == OPEN, c.worker.is_(None), others)
        due = runs.step_seconds + sa.select(sa.func.min(c.sent)).where(waiting).scalar_subquery()
        start = sa.case((runs.away_until > due, runs.away_until), else_=due)
        left = runs.bank_left - sa.case((start < now, now - start), else_=0.0)
        values = {"bank_left": sa.case((left > 0.0, left), else_=0.0), "away_until": now}
        connection.execute(tables.runs.update().where(runs.run_id == run_id, runs.step_seconds > 0.0).values(values))
