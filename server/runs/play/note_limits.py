"""Limits of the notes that agents leave beside their steps."""

from dataclasses import dataclass

from arramon_client.world import NOTE_BYTES

RUN_NOTE_BYTES = 50_000_000
"""Limit of all notes of a run unless the host sets another, in bytes of UTF-8."""


@dataclass(frozen=True, slots=True)
class NoteLimits:
    """Limits of notes, in bytes of UTF-8.

    Attributes:
        note: limit of one note; 0: no notes are stored.
        run: limit of all notes of a run.
    """

    note: int = NOTE_BYTES
    run: int = RUN_NOTE_BYTES


DEFAULT_NOTE_LIMITS = NoteLimits()
