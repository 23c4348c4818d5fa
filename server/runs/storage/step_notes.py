"""Notes that agents left beside their steps, apart from the steps' own table and outside all digests and receipts."""

from typing import Any

import sqlalchemy as sa

from arramon_server.runs.storage import tables
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.records import StepNote


class StepNotes:
    """Notes of all runs. Thread-safe. `steps.Steps.commit` writes them.

    Args:
        database: storage of the notes.
    """

    def __init__(self, database: Database) -> None:
        self._database = database

    def notes_of(self, run_id: str, episode_id: str) -> dict[int, str]:
        """Return the notes of an episode, by step."""
        table = tables.step_notes
        query = sa.select(table.c.step, table.c.note).where(table.c.run_id == run_id, table.c.episode_id == episode_id)
        return {row.step: row.note for row in self._database.read(query)}

    def note_page(
        self, run_id: str, limit: int, *, episode_id: str | None = None, last: tuple[str, int] | None = None
    ) -> list[StepNote]:
        """Return at most `limit` notes of a run, by episode and step.

        Args:
            run_id: id of the run.
            limit: maximum number of notes.
            episode_id: only the notes of this episode; None for all.
            last: episode and step of the note before the first one to return; None to start with the first.
        """
        c = tables.step_notes.c
        conditions: list[Any] = [c.run_id == run_id]
        if episode_id is not None:
            conditions.append(c.episode_id == episode_id)
        if last is not None:
            conditions.append(sa.tuple_(c.episode_id, c.step) > last)
        query = sa.select(c.episode_id, c.step, c.note).where(*conditions).order_by(c.episode_id, c.step).limit(limit)
        return [StepNote(row.episode_id, row.step, row.note) for row in self._database.read(query)]

    def notes_size(self, run_id: str) -> int:
        """Return the total size of a run's notes, in bytes of UTF-8."""
        rows = self._database.read(sa.select(tables.runs.c.notes_size).where(tables.runs.c.run_id == run_id))
        return int(rows[0].notes_size) if rows else 0

    def has_episode(self, run_id: str, episode_id: str) -> bool:
        """Return whether a run has an episode."""
        c = tables.episodes.c
        query = sa.select(c.ordinal).where(c.run_id == run_id, c.episode_id == episode_id)
        return bool(self._database.read(query))
