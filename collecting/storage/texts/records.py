"""Texts and verifications as dataclasses, and the names of their states."""

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import Any

from arramon_server.errors import NotFound

VERIFYING, KEPT, DISCARDED, IN_REVIEW, SENT_BACK, REJECTED, WITHDRAWN = (
    "verifying", "kept", "discarded", "in_review", "sent_back", "rejected", "withdrawn",
)  # fmt: skip
"""States of a text: withdrawn is that of a person who left and did not want to leave the texts."""

HINT = "hint"
"""Severity of failed checks that only advise the writer, beside the languages' "blocked" and "suspicious"."""

PRESENT = (VERIFYING, KEPT, IN_REVIEW, SENT_BACK)
"""States of texts for which nobody else writes instructions of the same episode."""

Instructions = tuple[tuple[str, str], ...]
"""Navigation and assembly text of each turn."""


@dataclass(frozen=True, slots=True)
class Text:
    """The instructions of both turns of one episode.

    Attributes:
        text_id: id, random.
        collection: name of the collection.
        task_id: the task in which it was written; None if it was imported for a review.
        worker_id: the author; None if it was imported.
        episode_id, language: what it is for.
        instructions: navigation and assembly text of each turn; empty if it was deleted.
        failures: the checks that it failed: `{"turn", "phase", "check", "severity", "message"}`.
        evidence: signs of pasted or generated text, for reviewers.
        state: one of the states above.
        version: 1, and one more for each mended version.
        history: earlier versions: `{"version", "instructions", "at", "reason", "by"}`.
        reason: why it was sent back or rejected.
        created_at, reviewed_at: when it was submitted and reviewed.
        reviewed_by: id of the host who did; None for none.
    """

    text_id: str
    collection: str
    task_id: str | None
    worker_id: str | None
    episode_id: str
    language: str
    instructions: Instructions
    failures: tuple[Mapping[str, Any], ...]
    evidence: Mapping[str, Any]
    state: str
    version: int
    history: tuple[Mapping[str, Any], ...]
    reason: str
    created_at: datetime
    reviewed_at: datetime | None
    reviewed_by: str | None

    def instructions_of(self, version: int) -> Instructions:
        """Return the instructions of a version, also an earlier one.

        Raises:
            NotFound: if there is no such version.
        """
        if version == self.version:
            return self.instructions
        for earlier in self.history:
            if earlier["version"] == version:
                return tuple((str(navigation), str(assembly)) for navigation, assembly in earlier["instructions"])
        raise NotFound(f"text {self.text_id} has no version {version}; the latest is {self.version}")


@dataclass(frozen=True, slots=True)
class Verification:
    """A followed text.

    Attributes:
        task_id: the task.
        collection: name of the collection.
        text_id: the text; None for a gold.
        episode_id: the episode.
        worker_id: who followed it.
        run_id: the run in which it was played.
        ndtw, ptc: scores of both turns, from 0 to 1.
        placed_cells: column, level and row of the cell in which the object was placed, by turn; None if it was not.
        path: the walk (x, z) of each turn; path and cells are empty if they were deleted with the worker's data.
        flags: boxes that were ticked, such as "unclear".
        seconds: active time; 0 if it was deleted.
        counts: whether it counts for the text; not if it was too quick.
        created_at: when it was submitted.
    """

    task_id: str
    collection: str
    text_id: str | None
    episode_id: str
    worker_id: str
    run_id: str
    ndtw: tuple[float, ...]
    ptc: tuple[float, ...]
    placed_cells: tuple[tuple[int, int, int] | None, ...]
    path: tuple[tuple[tuple[float, float], ...], ...]
    flags: tuple[str, ...]
    seconds: float
    counts: bool
    created_at: datetime

    @property
    def measured_seconds(self) -> float | None:
        """Active time; None if it was deleted."""
        return self.seconds or None

    @property
    def has_walk(self) -> bool:
        """Whether the walk is there: it is deleted with the worker's data."""
        return bool(self.path)
