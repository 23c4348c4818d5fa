"""Notes that agents leave beside their steps: cleaned, limited in size, and added to the commit of the step."""

import time
from collections.abc import Callable
from dataclasses import dataclass

from arramon_server.runs.play.note_limits import NoteLimits
from arramon_server.runs.storage.records import CommitBatch
from arramon_server.runs.storage.step_notes import StepNotes
from arramon_server.visible_text import shown_lines

FRESH_SECONDS = 1.0
"""Time for which the size of a run's notes is counted without reading what other processes have added."""


@dataclass(slots=True)
class _Usage:
    """Size of a run's notes, in bytes, and the time at which the journal was read."""

    size: int
    read_at: float


class NoteTaker:
    """Checks notes, and adds them to commit batches.

    Several processes that play one run may together exceed its limit by what they store in FRESH_SECONDS.

    Args:
        notes: counts what is stored.
        limits: limits of notes.
        now: monotonic clock, in seconds.
    """

    def __init__(self, notes: StepNotes, limits: NoteLimits, now: Callable[[], float] = time.monotonic) -> None:
        self._notes = notes
        self._limits = limits
        self._now = now
        self._usage: dict[str, _Usage] = {}

    def add(self, batch: CommitBatch, run_id: str, episode_id: str, step: int, note: str) -> str:
        """Add a note to a batch that has its step; return why it is refused instead, or an empty text.

        Raises:
            StorageError: if the journal cannot be read.
        """
        limits = self._limits
        if not limits.note:
            return "this server does not store notes (note_bytes is 0)"
        size = len(note.encode())
        if size <= limits.note:  # a longer one is not worth cleaning
            note = shown_lines(note)
            size = len(note.encode())
        if size > limits.note:
            return f"the note has {size} bytes in UTF-8, expected at most {limits.note}"
        usage = self._usage_of(batch, run_id)
        if usage.size + size > limits.run:
            return f"the run's notes have {usage.size} bytes, and {size} more would exceed the limit of {limits.run}"
        usage.size += size
        batch.add_note(run_id, episode_id, step, note)
        return ""

    def _usage_of(self, batch: CommitBatch, run_id: str) -> _Usage:
        """Return the usage of a run: what the journal has, and what the batch will add."""
        now = self._now()
        usage = self._usage.get(run_id)
        if usage is None or now > usage.read_at + FRESH_SECONDS:
            if usage is None:  # runs that no longer store notes are forgotten
                self._usage = {key: kept for key, kept in self._usage.items() if now <= kept.read_at + FRESH_SECONDS}
            added = sum(len(row["note"].encode()) for row in batch.notes if row["run_id"] == run_id)
            usage = self._usage[run_id] = _Usage(self._notes.notes_size(run_id) + added, now)
        return usage
