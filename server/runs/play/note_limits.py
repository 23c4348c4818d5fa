"""Limits of the notes that agents leave beside their steps."""

from dataclasses import dataclass

MAX_NOTE_BYTES, MAX_RUN_NOTE_BYTES = 2048, 50_000_000
"""Limits of one note and of all notes of a run unless the host sets others, in bytes of UTF-8."""


@dataclass(frozen=True, slots=True)
class NoteLimits:
    """Limits of notes, in bytes of UTF-8.

    Attributes:
        note: limit of one note; 0: no notes are stored.
        run: limit of all notes of a run.
    """

    note: int = MAX_NOTE_BYTES
    run: int = MAX_RUN_NOTE_BYTES


DEFAULT_NOTE_LIMITS = NoteLimits()
