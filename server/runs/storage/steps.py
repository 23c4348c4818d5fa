"""Recorded steps and endings of episodes: append-only, and unique by (run, episode, step)."""

from collections import Counter, defaultdict
from collections.abc import Collection
from operator import attrgetter, itemgetter
from typing import Any

import sqlalchemy as sa
from sqlalchemy.engine import Row

from arramon_server.errors import TakenOver
from arramon_server.runs.storage import tables
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.records import ENDED, RUNNING, CommitBatch, EpisodeEnding


class Steps:
    """Steps and endings of all runs. Thread-safe, except for `commit`.

    Args:
        database: storage of the steps.
    """

    def __init__(self, database: Database) -> None:
        self._database = database

    def actions(self, run_id: str, episode_id: str, first: int = 0) -> list[int]:
        """Return the recorded actions of an episode from step `first` on, in order."""
        table = tables.steps
        query = (
            sa.select(table.c.action)
            .where(table.c.run_id == run_id, table.c.episode_id == episode_id, table.c.step >= first)
            .order_by(table.c.step)
        )
        return [row[0] for row in self._database.read(query)]

    def episode_state(self, run_id: str, episode_id: str) -> tuple[str, EpisodeEnding | None] | None:
        """Return the state of a run's episode, and how it ended if it has; None if the run has no such episode."""
        c = tables.episodes.c
        query = sa.select(tables.episodes).where(c.run_id == run_id, c.episode_id == episode_id)
        rows = self._database.read(query)
        if not rows:
            return None
        return rows[0].state, _ending(run_id, rows[0]) if rows[0].state == ENDED else None

    def endings(self, run_id: str) -> list[EpisodeEnding]:
        """Return the endings of a run's ended episodes, in playing order."""
        table = tables.episodes
        query = sa.select(table).where(table.c.run_id == run_id, table.c.state == ENDED).order_by(table.c.ordinal)
        return [_ending(run_id, row) for row in self._database.read(query)]

    def ended_in(self, run_ids: Collection[str], episode_id: str) -> set[str]:
        """Return the ids of those runs in which an episode has ended."""
        c = tables.episodes.c
        query = sa.select(c.run_id).where(c.run_id.in_(run_ids), c.episode_id == episode_id, c.state == ENDED)
        return {row[0] for row in self._database.read(query)}

    def commit(self, batch: CommitBatch) -> None:
        """Write steps, their notes, endings and charges in one transaction.

        Raises:
            TakenOver: if a step is recorded already, or a claim is no longer held: another process has the episode.
            StorageError: if the database cannot be written.
        """
        if not (batch.steps or batch.endings or batch.charges):
            return
        # Always in the same order: processes that lock episodes in different orders could deadlock.
        steps = sorted(batch.steps, key=itemgetter("run", "episode", "number"))
        taken_over = "another process of this server has taken over an episode, or it has ended"
        if not (batch.endings or batch.charges) and (self._database.is_file or not batch.notes):
            if not self._database.commit_rows(
                _INSERT_STEP, steps, at_once=_INSERT_STEPS, more=_inserts_of_notes(batch)
            ):
                raise TakenOver(taken_over)
            return
        with self._database.commit() as connection:
            if steps and connection.execute(_INSERT_STEP, steps).rowcount != len(steps):
                raise TakenOver(taken_over)
            if batch.notes:
                connection.execute(_INSERT_NOTE, batch.notes)
            for ending in sorted(batch.endings, key=attrgetter("run_id", "episode_id")):
                values = {name: getattr(ending, name) for name in _WRITTEN}
                values["note"] = ending.note.replace("\0", "")  # not allowed in texts of PostgreSQL
                done = connection.execute(
                    tables.episodes.update()
                    .where(_is_held(ending.run_id, ending.episode_id, ending.fence))
                    .values(state=ENDED, **values)
                )
                if not done.rowcount:
                    raise TakenOver(f"another process of this server has taken over episode {ending.episode_id!r}")
            for run_id, values in sorted(_run_updates(batch).items()):
                connection.execute(tables.runs.update().where(tables.runs.c.run_id == run_id).values(values))
            for run_id, (state, ended_at) in batch.over.items():
                is_over = sa.and_(tables.runs.c.run_id == run_id, tables.runs.c.state == RUNNING, ~_has_unended(run_id))
                connection.execute(tables.runs.update().where(is_over).values(state=state, ended_at=ended_at))

    def lost_episodes(self, batch: CommitBatch) -> set[tuple[str, str]]:
        """Return the episodes of a batch, as (run, episode), whose claims no longer have the fences in the batch."""
        fences = {(step["run"], step["episode"]): step["epoch"] for step in batch.steps}
        fences |= {(ending.run_id, ending.episode_id): ending.fence for ending in batch.endings}
        c = tables.episodes.c
        query = sa.select(c.run_id, c.episode_id, c.epoch).where(c.state != ENDED)
        rows = self._database.read(query.where(sa.tuple_(c.run_id, c.episode_id).in_(list(fences))))
        held = {(row.run_id, row.episode_id): row.epoch for row in rows}
        return {key for key, fence in fences.items() if held.get(key) != fence}

    def players_of(self, episodes: Collection[tuple[str, str]]) -> dict[tuple[str, str], str | None]:
        """Return the player who last claimed each of these episodes, by (run, episode).

        That is `records.CLOSER` if the run was closed early, and None if the episode was never claimed.
        """
        c = tables.episodes.c
        query = sa.select(c.run_id, c.episode_id, c.player)
        rows = self._database.read(query.where(sa.tuple_(c.run_id, c.episode_id).in_(list(episodes))))
        return {(row.run_id, row.episode_id): row.player for row in rows}


def _ending(run_id: str, row: Row[Any]) -> EpisodeEnding:
    return EpisodeEnding(run_id, row.episode_id, row.cause, row.steps, row.scores, row.note or "")


def _run_updates(batch: CommitBatch) -> dict[str, dict[str, Any]]:
    """Return the new values of runs' columns, by run: the bank after its charge, the size of all notes."""
    updates, c = defaultdict[str, dict[str, Any]](dict), tables.runs.c
    for run_id, seconds in batch.charges.items():
        updates[run_id]["bank_left"] = sa.case((c.bank_left > seconds, c.bank_left - seconds), else_=0.0)
    for run_id, size in _sizes_of_notes(batch).items():
        updates[run_id]["notes_size"] = c.notes_size + size
    return updates


def _inserts_of_notes(batch: CommitBatch) -> list[tuple[sa.Executable, list[dict[str, Any]]]]:
    """Return the statements that write the notes of a batch and add up their sizes, with their parameters."""
    if not batch.notes:
        return []
    sizes = [{"run": run_id, "size": size} for run_id, size in _sizes_of_notes(batch).items()]
    return [(_INSERT_NOTE, batch.notes), (_ADD_SIZE, sizes)]


def _sizes_of_notes(batch: CommitBatch) -> Counter[str]:
    """Return the size of the notes in a batch, in bytes of UTF-8, by run."""
    sizes = Counter[str]()
    for note in batch.notes:
        sizes[note["run_id"]] += len(note["note"].encode())
    return sizes


_INSERT_NOTE = tables.step_notes.insert()

_ADD_SIZE = (
    tables.runs.update()
    .where(tables.runs.c.run_id == sa.bindparam("run"))
    .values(notes_size=tables.runs.c.notes_size + sa.bindparam("size", type_=sa.Integer))
)
"""Statement that adds to the total size of a run's notes."""

_WRITTEN = ("cause", "steps", "scores", "thinking_seconds", "timed_steps")
"""Columns of an episode that its ending writes, besides the note."""


def _has_unended(run_id: str) -> sa.ColumnElement[bool]:
    c = tables.episodes.c
    return sa.exists().where(c.run_id == run_id, c.state != ENDED)


def _is_held(run_id: Any, episode_id: Any, fence: Any) -> sa.ColumnElement[bool]:
    """Return the SQL condition that an episode has not ended and its claim still has the given fence."""
    c = tables.episodes.c
    return sa.and_(c.run_id == run_id, c.episode_id == episode_id, c.epoch == fence, c.state != ENDED)


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
"""Statement that inserts a step if the claim with the given fence is still held, and nothing otherwise.

It locks the episode's row (on PostgreSQL; SQLite has one writer at a time): a concurrent claim either waits until the
step is written, or is waited for and then seen, so that nothing is inserted.
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
""").execution_options(preserve_rowcount=True)  # noqa: S608 - the only inserted text is a constant
"""The same for many steps in one statement, for PostgreSQL: inserts all, or none if any claim is lost."""
