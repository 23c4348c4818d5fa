"""Who holds the episodes of a run: those that are open, those that are next, and how they are taken and let go."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace

import sqlalchemy as sa

from server.runs import tables
from server.runs.database import Database
from server.runs.records import ENDED, OPEN, PENDING, Claim


class Claims:
    """The claims of all runs. Safe to use from several threads.

    Args:
        database: where they are kept.
    """

    def __init__(self, database: Database) -> None:
        self._database = database

    def open_claims(self, run_id: str, limit: int | None = None) -> list[Claim]:
        """The run's first episodes that were begun and have not ended."""
        episodes, workers = tables.episodes, tables.workers
        query = (
            sa.select(
                episodes.c.episode_id,
                episodes.c.state,
                episodes.c.player,
                episodes.c.epoch,
                episodes.c.waited,
                workers.c.worker_id,
                # A clock that jumped back leaves times in the future: they are as old as they are far away.
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
        """The run's next episodes that nobody has begun."""
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
        """Makes episodes `player`'s at a worker, and returns those that were still as `claims` has them.

        Args:
            run_id: of the run.
            claims: as they were read.
            player: the stream's own name.
            worker: this process.
            reoffered: those, by id, that are offered again by the server's fault.
        """
        c = tables.episodes.c

        def these(wanted: Iterable[Claim]) -> sa.ColumnElement[bool]:
            return sa.and_(c.run_id == run_id, c.episode_id.in_([claim.episode_id for claim in wanted]))

        with self._database.write() as connection:
            # Locked before they are looked at: what another process is about to write to them is waited for, and seen.
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
                # The stream knows now how long its step has waited; what a process that dies forgets is not charged.
                connection.execute(tables.episodes.update().where(these(won)).values(values))
        return [replace(claim, epoch=claim.epoch + 1) for claim in won]

    def release(
        self, run_id: str, epochs: Mapping[str, int], *, ago: float = 0.0, waited: Mapping[str, float] | None = None
    ) -> None:
        """Lets go of open episodes that are still held under these epochs.

        Args:
            run_id: of the run.
            epochs: by episode.
            ago: seconds since their stream left.
            waited: by episode how many seconds the present step's clock had run.
        """
        c, left = tables.episodes.c, self._database.now - ago
        held = sa.and_(c.run_id == run_id, c.episode_id == sa.bindparam("id"), c.epoch == sa.bindparam("held"))
        statement = tables.episodes.update().where(held).values(worker=None, left=left, waited=sa.bindparam("seconds"))
        rows = [
            {"id": episode_id, "held": epoch, "seconds": (waited or {}).get(episode_id, 0.0)}
            for episode_id, epoch in sorted(epochs.items())  # in one order everywhere, as in `commit`
        ]
        if rows:
            with self._database.write() as connection:
                connection.execute(statement, rows)
