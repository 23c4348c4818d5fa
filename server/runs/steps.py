"""The steps of episodes, and how these ended: append-only, and unique by (run, episode, step)."""

from operator import attrgetter, itemgetter
from typing import Any

import sqlalchemy as sa

from server.errors import TakenOver
from server.runs import tables
from server.runs.database import Database
from server.runs.records import ENDED, Batch, Ending


class Steps:
    """All steps ever answered. Safe to read from several threads; `commit` belongs to one.

    Args:
        database: where they are kept.
    """

    def __init__(self, database: Database) -> None:
        self._database = database

    def actions(self, run_id: str, episode_id: str) -> list[int]:
        """The actions recorded for an episode, in order."""
        table = tables.steps
        query = (
            sa.select(table.c.action)
            .where(table.c.run_id == run_id, table.c.episode_id == episode_id)
            .order_by(table.c.step)
        )
        return [row[0] for row in self._database.read(query)]

    def endings(self, run_id: str) -> list[Ending]:
        """The run's ended episodes, in playing order."""
        table = tables.episodes
        query = sa.select(table).where(table.c.run_id == run_id, table.c.state == ENDED).order_by(table.c.ordinal)
        return [
            Ending(run_id, row.episode_id, row.cause, row.steps, row.scores, row.note or "")
            for row in self._database.read(query)
        ]

    def commit(self, batch: Batch) -> None:
        """Writes steps, endings and charges, all or nothing.

        Raises:
            TakenOver: if a step is there already, or a claim is not held any more: another process plays the episode.
            StorageError: if the database cannot be written.
        """
        if not (batch.steps or batch.endings or batch.charges):
            return
        # In one order everywhere: who locks episodes in another waits for whoever waits for them.
        steps = sorted(batch.steps, key=itemgetter("run", "episode", "number"))
        taken_over = "another process of this server has taken over an episode, or it has ended"
        if not (batch.endings or batch.charges):
            if not self._database.commit_rows(_INSERT_STEP, steps, at_once=_INSERT_STEPS):
                raise TakenOver(taken_over)
            return
        with self._database.commit() as connection:
            if steps and connection.execute(_INSERT_STEP, steps).rowcount != len(steps):
                raise TakenOver(taken_over)
            for ending in sorted(batch.endings, key=attrgetter("run_id", "episode_id")):
                values = {name: getattr(ending, name) for name in ("cause", "steps", "scores")}
                values["note"] = ending.note.replace("\0", "")  # PostgreSQL's texts hold none
                done = connection.execute(
                    tables.episodes.update()
                    .where(_is_held(ending.run_id, ending.episode_id, ending.epoch))
                    .values(state=ENDED, **values)
                )
                if not done.rowcount:
                    raise TakenOver(f"another process of this server has taken over episode {ending.episode_id!r}")
            for run_id, seconds in sorted(batch.charges.items()):
                left = tables.runs.c.bank_left
                values = {"bank_left": sa.case((left > seconds, left - seconds), else_=0.0)}
                connection.execute(tables.runs.update().where(tables.runs.c.run_id == run_id).values(values))

    def lost(self, batch: Batch) -> set[tuple[str, str]]:
        """The episodes of a batch, by run and id, that are not held any more under the claims that it names."""
        epochs = {(step["run"], step["episode"]): step["epoch"] for step in batch.steps}
        epochs |= {(ending.run_id, ending.episode_id): ending.epoch for ending in batch.endings}
        c = tables.episodes.c
        query = sa.select(c.run_id, c.episode_id, c.epoch).where(c.state != ENDED)
        rows = self._database.read(query.where(sa.tuple_(c.run_id, c.episode_id).in_(list(epochs))))
        held = {(row.run_id, row.episode_id): row.epoch for row in rows}
        return {key for key, epoch in epochs.items() if held.get(key) != epoch}


def _is_held(run_id: Any, episode_id: Any, epoch: Any) -> sa.ColumnElement[bool]:
    """Whether an episode has not ended and nobody has claimed it since."""
    c = tables.episodes.c
    return sa.and_(c.run_id == run_id, c.episode_id == episode_id, c.epoch == epoch, c.state != ENDED)


_INSERT_STEP = (
    tables.steps.insert()
    .from_select(
        ["run_id", "episode_id", "step", "action"],
        sa.select(
            tables.episodes.c.run_id,
            tables.episodes.c.episode_id,
            sa.bindparam("number", type_=sa.Integer),
            sa.bindparam("taken", type_=sa.Integer),
        )
        .where(_is_held(sa.bindparam("run"), sa.bindparam("episode"), sa.bindparam("epoch")))
        .with_for_update(key_share=True),
    )
    .execution_options(preserve_rowcount=True)
)
"""Writes a step under the claim of an epoch, and nothing where that is not held any more.

The episode's row is locked (on PostgreSQL; SQLite has one writer at a time): a claim that is made at the same moment
either waits until the step is written, or is waited for and then found to have taken the episode.
"""

_INSERT_STEPS = sa.text(f"""
    WITH given AS (
        SELECT * FROM unnest(
            CAST(:run AS text[]), CAST(:episode AS text[]), CAST(:epoch AS int[]), CAST(:number AS int[]),
            CAST(:taken AS int[])
        ) AS given (run_id, episode_id, epoch, number, taken)
    ),
    held AS (
        SELECT run_id, episode_id, number, taken FROM given JOIN run_episodes USING (run_id, episode_id, epoch)
        WHERE state != '{ENDED}' ORDER BY run_id, episode_id FOR NO KEY UPDATE OF run_episodes
    )
    INSERT INTO steps (run_id, episode_id, step, action)
    SELECT * FROM held WHERE (SELECT count(*) FROM held) = (SELECT count(*) FROM given)
""").execution_options(preserve_rowcount=True)  # noqa: S608 - of a constant
"""The same for many steps, in one statement of PostgreSQL's: all of them, or none where one is not held any more."""
