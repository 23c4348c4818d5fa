"""Claims of episodes: query, acquire and release them."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace

import sqlalchemy as sa

from server.runs.storage import tables
from server.runs.storage.database import Database
from server.runs.storage.records import ENDED, OPEN, PENDING, Claim


class Claims:
    """Claims of the episodes of all runs. Thread-safe.

    Args:
        database: storage of the claims.
    """

    def __init__(self, database: Database) -> None:
        self._database = database

    def open_claims(self, run_id: str, limit: int | None = None) -> list[Claim]:
        """Return the claims of a run's first `limit` open episodes, in playing order; None for all."""
        episodes, workers = tables.episodes, tables.workers
        query = (
            sa.select(
                episodes.c.episode_id,
                episodes.c.state,
                episodes.c.player,
                episodes.c.epoch,
                episodes.c.waited,
                workers.c.worker_id,
                # A clock that jumped back leaves times in the future: the absolute value counts as their age.
                sa.func.abs(self._database.now - sa.func.coalesce(episodes.c.left, workers.c.seen, 0.0)).label("idle"),
            )
            .outerjoin_from(episodes, workers, episodes.c.worker == workers.c.worker_id)
            .where(episodes.c.run_id == run_id, episodes.c.state == OPEN)
            .order_by(episodes.c.ordinal)
            .limit(limit)
        )
        return [
            Claim(row.episode_id, row.state, row.player, row.epoch, row.worker_id, row.idle, row.waited)
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
        """Claim episodes for a player and a worker, and return the new claims of those whose epochs had not changed.

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
            epochs: dict[str, int] = {row.episode_id: row.epoch for row in rows}
            won = [claim for claim in claims if epochs.get(claim.episode_id) == claim.epoch]
            values = {
                "state": OPEN,
                "player": player,
                "epoch": c.epoch + 1,
                "worker": worker,
                "left": None,
                "waited": 0.0,
            }
            again = [claim for claim in won if claim.episode_id in reoffered]
            if again:
                connection.execute(tables.episodes.update().where(these(again)).values(reoffers=c.reoffers + 1))
            if won:
                # From here on the stream's clock holds the waiting time; a process that dies loses it, uncharged.
                connection.execute(tables.episodes.update().where(these(won)).values(values))
        return [replace(claim, epoch=claim.epoch + 1) for claim in won]

    def release(
        self, run_id: str, epochs: Mapping[str, int], *, ago: float = 0.0, waited: Mapping[str, float] | None = None
    ) -> None:
        """Release the open episodes that are still held under the given epochs.

        Args:
            run_id: id of the run.
            epochs: epoch of the claim, by episode.
            ago: seconds since the stream closed.
            waited: seconds that the clock of the present step had run, by episode.
        """
        c, left = tables.episodes.c, self._database.now - ago
        held = sa.and_(c.run_id == run_id, c.episode_id == sa.bindparam("id"), c.epoch == sa.bindparam("held"))
        statement = tables.episodes.update().where(held).values(worker=None, left=left, waited=sa.bindparam("seconds"))
        rows = [
            {"id": episode_id, "held": epoch, "seconds": (waited or {}).get(episode_id, 0.0)}
            for episode_id, epoch in sorted(epochs.items())  # always in the same order, as in `commit`
        ]
        if rows:
            with self._database.write() as connection:
                connection.execute(statement, rows)
