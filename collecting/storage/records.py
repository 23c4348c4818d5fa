"""Rows of the tables of collections, as dataclasses, and the names of their states."""

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any, TypeVar

from sqlalchemy.engine import Row

from arramon_collecting.settings import Settings
from arramon_server.errors import NotFound
from arramon_server.runs.storage.database import utc

WRITE_KIND, REVIEW_KIND = "write", "review"
"""Kinds of collections: people write and verify, or hosts review the generated texts of a split."""

RUNNING, PAUSED, CLOSED = "running", "paused", "closed"
"""States of a collection."""

WRITE, VERIFY, REVIEW = "write", "verify", "review"
"""Stages of tasks."""

WORKER, HOST = "worker", "host"
"""Roles of those who sign in."""

INVITED, ACTIVE, WORKER_PAUSED, BLOCKED, LEFT, FORGOTTEN = "invited", "active", "paused", "blocked", "left", "forgotten"
"""States of a worker."""

OPEN, SUBMITTED, RETURNED, EXPIRED = "open", "submitted", "returned", "expired"
"""States of a task."""

VERIFYING, KEPT, DISCARDED, IN_REVIEW, SENT_BACK, REJECTED, WITHDRAWN = (
    "verifying", "kept", "discarded", "in_review", "sent_back", "rejected", "withdrawn",
)  # fmt: skip
"""States of a text: withdrawn is that of a person who left and did not want to leave the texts."""

HINT = "hint"
"""Severity of failed checks that only advise the writer, beside the languages' "blocked" and "suspicious"."""

PRESENT = (VERIFYING, KEPT, IN_REVIEW, SENT_BACK)
"""States of texts for which nobody else writes instructions of the same episode."""

QUEUED, SENDING, SENT, FAILED = "queued", "sending", "sent", "failed"
"""States of a mail."""

PAID_WRITE, PAID_VERIFY, PAID_KEPT = "write", "verify", "kept"
"""Kinds of ledger entries; those of milestones are `milestone-5` and so on."""

Instructions = tuple[tuple[str, str], ...]
"""Navigation and assembly text of each turn."""

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Collection:
    """A collection.

    Attributes:
        name: name, the part of its addresses.
        kind: WRITE_KIND or REVIEW_KIND.
        language: code of the language that is written.
        split: split whose episodes are written for.
        settings: its settings.
        consent, consent_hash: the text that workers agree to, and the SHA-256 of text and licence.
        state: RUNNING, PAUSED or CLOSED.
        created_at: when it was created.
    """

    name: str
    kind: str
    language: str
    split: str
    settings: Settings
    consent: str
    consent_hash: str
    state: str
    created_at: datetime


@dataclass(frozen=True, slots=True)
class Worker:
    """A worker, or a host who reviews.

    Attributes:
        worker_id: pseudonym, random.
        collection: name of the collection.
        role: WORKER or HOST.
        stages: the stages that the worker does.
        external_id: id on the crowd platform; None without one.
        note: note of the host, such as a name; only hosts see it.
        state: one of the states above.
        consented_at, consent_hash: when the worker agreed, and to what; None before.
        keep_texts: whether texts stay when the worker's data is deleted; None before the worker has agreed.
        screening: result of the screening test of each stage: `{"attempts": 1, "passed_at": ..., "until": ...}`.
        placement_passed_at: when the placement test was passed; None before.
        device: what was measured of the device; empty before.
        email: mail address; empty without one.
        page_language: language of the pages that the worker reads.
        created_at: when the worker was invited, or joined.
    """

    worker_id: str
    collection: str
    role: str
    stages: tuple[str, ...]
    external_id: str | None
    note: str
    state: str
    consented_at: datetime | None
    consent_hash: str | None
    keep_texts: bool | None
    screening: Mapping[str, Any]
    placement_passed_at: datetime | None
    device: Mapping[str, Any]
    email: str
    page_language: str
    created_at: datetime


@dataclass(frozen=True, slots=True)
class Visit:
    """One session of a crowd platform's worker: completed once the study's tasks are submitted, or returned."""

    visit_id: str
    worker_id: str
    study_id: str
    session_id: str
    joined_at: datetime
    completed_at: datetime | None
    returned_at: datetime | None


@dataclass(frozen=True, slots=True)
class SignIn:
    """A sign-in of a browser.

    Attributes:
        worker_id: who signed in.
        csrf: value that every form and request that changes state repeats.
        renewed_at: when the cookie was given out.
        expires_at: when it ends.
    """

    worker_id: str
    csrf: str
    created_at: datetime
    renewed_at: datetime
    expires_at: datetime


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
        active_seconds: time during which the worker was active.
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


@dataclass(frozen=True, slots=True)
class Draft:
    """The saved draft of a task; every save increases the revision, which begins at 0 for none."""

    task_id: str
    revision: int
    body: Mapping[str, Any]
    saved_at: datetime | None


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
        path: the walk (x, z) of each turn.
        flags: boxes that were ticked, such as "unclear".
        seconds: active time.
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


@dataclass(frozen=True, slots=True)
class LedgerEntry:
    """An amount owed to a worker for a subject: a task, a text or a milestone."""

    entry_id: str
    collection: str
    worker_id: str
    kind: str
    subject: str
    amount_minor: int
    currency: str
    created_at: datetime


@dataclass(frozen=True, slots=True)
class Mail:
    """A mail in the queue."""

    mail_id: str
    collection: str
    worker_id: str
    recipient: str
    subject: str
    body: str
    state: str
    attempts: int
    problem: str
    next_at: datetime
    created_at: datetime


def record_of(kind: type[T], row: Row[Any]) -> T:
    """Return a row as one of these dataclasses: times in UTC, lists as tuples."""
    values = row._mapping
    fields = dataclasses.fields(kind)  # type: ignore[arg-type]
    return kind(**{field.name: _value(values[field.name]) for field in fields})


def _value(value: Any) -> Any:
    if isinstance(value, datetime):
        return utc(value)
    return _frozen(value) if isinstance(value, list) else value


def _frozen(value: Any) -> Any:
    """Return a JSON value with its lists, but not those within objects, as tuples."""
    return tuple(map(_frozen, value)) if isinstance(value, Sequence) and not isinstance(value, str) else value
