"""Tasks and drafts as dataclasses, and the names of their states."""

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import Any

WRITE, VERIFY, REVIEW = "write", "verify", "review"
"""Stages of tasks."""

OPEN, SUBMITTED, RETURNED, EXPIRED = "open", "submitted", "returned", "expired"
"""States of a task."""


@dataclass(frozen=True, slots=True)
class Task:
    """A task of a worker.

    Attributes:
        task_id: id, random.
        collection: name of the collection.
        stage: WRITE, VERIFY or REVIEW.
        worker_id: who does it.
        episode_id: the episode.
        text_id: the text that is verified, or mended; None for a new one and for a gold.
        is_gold: whether the instructions are known ones of the split, to measure the worker.
        state: OPEN, SUBMITTED, RETURNED or EXPIRED.
        started_at, seen_at, ended_at: when it was given out, last used, and ended.
        active_seconds: time during which the worker was active; 0 if it was deleted with the worker's data.
        submission_id: id that the page gave the submission, so that it counts once.
        run_id: the run in which a verification is played; None for none.
        position: where a writer stands, for the next visit; empty at first.
    """

    task_id: str
    collection: str
    stage: str
    worker_id: str
    episode_id: str
    text_id: str | None
    is_gold: bool
    state: str
    started_at: datetime
    seen_at: datetime
    ended_at: datetime | None
    active_seconds: float
    submission_id: str | None
    run_id: str | None
    position: Mapping[str, Any]

    @property
    def measured_seconds(self) -> float | None:
        """Time during which the worker was active; None if it was deleted."""
        return self.active_seconds or None


@dataclass(frozen=True, slots=True)
class Draft:
    """The saved draft of a task; every save increases the revision, which begins at 0 for none."""

    task_id: str
    revision: int
    body: Mapping[str, Any]
    saved_at: datetime | None
