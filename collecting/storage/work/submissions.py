"""Submissions of tasks: each in one transaction with what it decides and pays, and counted once."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any

import sqlalchemy as sa
from sqlalchemy.engine import Connection

from arramon_collecting.rules.keeping import DISCARD, KEEP, Outcome, decide
from arramon_collecting.rules.payment import (
    Payment,
    payment_for_kept_text,
    payment_for_verification,
    payments_for_text,
)
from arramon_collecting.storage.payments.ledger import accepted_texts, pay
from arramon_collecting.storage.records import Collection, record_of
from arramon_collecting.storage.texts.records import (
    DISCARDED,
    HINT,
    IN_REVIEW,
    KEPT,
    VERIFYING,
    Instructions,
    Text,
    Verification,
)
from arramon_collecting.storage.transactions import Clock, lock, new_id, utc_now
from arramon_collecting.storage.work.drafts import active_seconds
from arramon_collecting.storage.work.records import EXPIRED, OPEN, SUBMITTED, VERIFY, WRITE, Task
from arramon_collecting.storage.work.task_queries import is_free, open_task
from arramon_server.errors import BadInput, Conflict, NotFound, quoted
from arramon_server.runs.storage.collection_tables import drafts, tasks, texts, verifications
from arramon_server.runs.storage.database import Database


@dataclass(frozen=True, slots=True)
class Play:
    """How a worker followed a text; its fields are those of `Verification`."""

    run_id: str
    ndtw: tuple[float, ...]
    ptc: tuple[float, ...]
    placed_cells: Sequence[Sequence[int] | None]
    path: Sequence[Sequence[tuple[float, float]]]
    flags: tuple[str, ...]
    seconds: float


@dataclass(frozen=True, slots=True)
class Submission:
    """An accepted submission.

    Attributes:
        task: the submitted task.
        text: the text that was written or verified; None for a gold.
        paid: what was paid for it, to anybody.
        repeated: whether it had been submitted before, and nothing was changed now.
    """

    task: Task
    text: Text | None
    paid: tuple[Payment, ...] = ()
    repeated: bool = False


class Submissions:
    """Submissions of all collections.

    Args:
        database: the journal's database.
        clock: returns the present time.
    """

    def __init__(self, database: Database, clock: Clock = utc_now) -> None:
        self._database = database
        self._clock = clock

    def submit_text(
        self,
        collection: Collection,
        task: Task,
        submission_id: str,
        instructions: Instructions,
        failures: Sequence[Mapping[str, Any]] = (),
        evidence: Mapping[str, Any] | None = None,
    ) -> Submission:
        """Submit a written text, or the mended one of a text that was sent back.

        A text goes to the verifiers and is paid at once, unless it failed checks, was written too quickly, or was sent
        back before: then a host reviews it first.

        Args:
            collection: the task's collection.
            task: an open task of the stage "write", or one that has expired and that nobody else does.
            submission_id: id that the page drew for the submission; the same one again changes nothing.
            instructions: texts that `clean_instructions` returned.
            failures: the checks that they failed, none of which blocks; hints alone call for no review.
            evidence: signs of pasted or generated text.

        Raises:
            BadInput: if a failed check blocks the text.
            Conflict: if the task is not open any more, or was submitted with another id.
        """
        if blocking := [one for one in failures if one.get("severity") == "blocked"]:
            raise BadInput(f"the text fails a check: {blocking[0].get('message')}")
        with self._database.write() as connection:
            found = self._begin(connection, collection, task, submission_id, WRITE)
            if found.state == SUBMITTED:
                return Submission(found, _text_of(connection, found), repeated=True)
            now = self._clock()
            active = active_seconds(found, now)
            is_too_quick = active < collection.settings.min_seconds_write
            is_doubtful = is_too_quick or any(one["severity"] != HINT for one in failures)
            row = {
                "instructions": [list(pair) for pair in instructions],
                "failures": list(map(dict, failures)),
                "evidence": dict(evidence or {}),
                "state": IN_REVIEW if is_doubtful or found.text_id is not None else VERIFYING,
            }
            text = _written(connection, collection, found, row, now)
            paid = accept(connection, collection, text, now) if text.state == VERIFYING else ()
            done = _end(connection, found, submission_id, now, active_seconds=active, text_id=text.text_id)
            return Submission(done, text, paid)

    def submit_verification(self, collection: Collection, task: Task, submission_id: str, play: Play) -> Submission:
        """Submit a verification, and decide about the text if it is the last one needed.

        Args:
            collection: the task's collection.
            task: an open task of the stage "verify", or one that has expired.
            submission_id: id of the submission; the same one again changes nothing.
            play: how the worker followed the text; if it was too quick, it neither counts nor is paid.

        Raises:
            Conflict: if the task is not open any more, or was submitted with another id.
        """
        settings = collection.settings
        with self._database.write() as connection:
            found = self._begin(connection, collection, task, submission_id, VERIFY)
            if found.state == SUBMITTED:
                return Submission(found, _text_of(connection, found), repeated=True)
            now, counts = self._clock(), play.seconds >= settings.min_seconds_verify
            row = {
                "task_id": found.task_id,
                "collection": collection.name,
                "text_id": found.text_id,
                "episode_id": found.episode_id,
                "worker_id": found.worker_id,
                "run_id": play.run_id,
                "ndtw": list(play.ndtw),
                "ptc": list(play.ptc),
                "placed_cells": [list(cell) if cell is not None else None for cell in play.placed_cells],
                "path": [[list(point) for point in path] for path in play.path],
                "flags": list(play.flags),
                "seconds": play.seconds,
                "counts": counts,
                "created_at": now,
            }
            connection.execute(verifications.insert(), [row])
            paid: list[Payment] = []
            if counts:
                payments = [payment_for_verification(found.task_id, settings)]
                paid += pay(connection, collection.name, found.worker_id, payments, settings, now)
            done = _end(connection, found, submission_id, now, active_seconds=play.seconds, run_id=play.run_id)
            if found.text_id is not None:
                paid += settle(connection, collection, found.text_id, now)
            return Submission(done, _text_of(connection, done), tuple(paid))

    @staticmethod
    def _begin(connection: Connection, collection: Collection, task: Task, submission_id: str, stage: str) -> Task:
        """Lock the collection; return the task, which is open, or was submitted with the same id before."""
        if not 1 <= len(submission_id) <= 64:
            raise BadInput(f"the submission's id is {quoted(submission_id)}, expected 1 to 64 characters")
        lock(connection, collection.name)
        row = connection.execute(sa.select(tasks).where(tasks.c.task_id == task.task_id)).first()
        if row is None or row.stage != stage or row.collection != collection.name:
            raise NotFound(f"there is no task {quoted(task.task_id)} of the stage {stage!r}")
        found = record_of(Task, row)
        if found.state == SUBMITTED and found.submission_id == submission_id:
            return found
        if found.state == EXPIRED and is_free(connection, found) and open_task(connection, found.worker_id) is None:
            return found  # What was written too slowly is not lost, as long as nobody else has the episode.
        if found.state != OPEN:
            raise Conflict(f"the task is {found.state} already, expected an open one")
        return found


def accept(connection: Connection, collection: Collection, text: Text, now: datetime) -> tuple[Payment, ...]:
    """Pay the author of a text that was accepted: for the text, and for milestones that it reaches."""
    if text.worker_id is None:
        return ()
    settings = collection.settings
    first = pay(
        connection, collection.name, text.worker_id, [next(payments_for_text(text.text_id, 0, settings))], settings, now
    )
    accepted = accepted_texts(connection, text.worker_id)
    payments = payments_for_text(text.text_id, accepted, settings)
    return (*first, *pay(connection, collection.name, text.worker_id, payments, settings, now))


def settle(connection: Connection, collection: Collection, text_id: str, now: datetime) -> list[Payment]:
    """Decide about a text whose verifications suffice, and pay its author if it is kept. Others stay as they are."""
    text = record_of(Text, connection.execute(sa.select(texts).where(texts.c.text_id == text_id)).one())
    decision = decide(outcomes_of(connection, text_id), collection.settings)
    if text.state != VERIFYING or decision is None:
        return []
    state = {KEEP: KEPT, DISCARD: DISCARDED}.get(decision, IN_REVIEW)
    connection.execute(texts.update().where(texts.c.text_id == text_id).values(state=state))
    return pay_if_kept(connection, collection, text, state, now)


def pay_if_kept(connection: Connection, collection: Collection, text: Text, state: str, now: datetime) -> list[Payment]:
    """Pay the author's bonus for a text that has come to the state "kept"."""
    if state != KEPT or text.worker_id is None:
        return []
    payments = [payment_for_kept_text(text.text_id, collection.settings)]
    return pay(connection, collection.name, text.worker_id, payments, collection.settings, now)


def outcomes_of(connection: Connection, text_id: str) -> list[Outcome]:
    """Return the outcomes of a text's verifications that count, oldest first."""
    query = sa.select(verifications).where(verifications.c.text_id == text_id, verifications.c.counts)
    rows = connection.execute(query.order_by(verifications.c.created_at))
    found = [record_of(Verification, row) for row in rows]
    return [Outcome(one.ndtw, one.ptc, bool(one.flags)) for one in found]


def _written(
    connection: Connection, collection: Collection, task: Task, values: Mapping[str, Any], now: datetime
) -> Text:
    """Insert a new text, or put a mended one in the place of that which was sent back."""
    if task.text_id is None:
        row = {
            "text_id": new_id(),
            "collection": collection.name,
            "task_id": task.task_id,
            "worker_id": task.worker_id,
            "episode_id": task.episode_id,
            "language": collection.language,
            "version": 1,
            "history": [],
            "created_at": now,
            **values,
        }
        connection.execute(texts.insert(), [row])
        return _text(connection, row["text_id"])
    replace_text(connection, _text(connection, task.text_id), values, now, by=task.worker_id)
    return _text(connection, task.text_id)


def replace_text(connection: Connection, earlier: Text, values: Mapping[str, Any], now: datetime, *, by: str) -> None:
    """Replace the instructions of a text by a new version; verifications of the earlier one no longer count."""
    kept = {
        "version": earlier.version,
        "instructions": [list(pair) for pair in earlier.instructions],
        "reason": earlier.reason,
        "at": now.isoformat(),
        "by": by,
    }
    changed = {"version": earlier.version + 1, "history": [*earlier.history, kept], **values}
    connection.execute(texts.update().where(texts.c.text_id == earlier.text_id).values(**changed))
    its = verifications.c.text_id == earlier.text_id
    connection.execute(verifications.update().where(its).values(counts=False))


def _text(connection: Connection, text_id: str) -> Text:
    return record_of(Text, connection.execute(sa.select(texts).where(texts.c.text_id == text_id)).one())


def _text_of(connection: Connection, task: Task) -> Text | None:
    return _text(connection, task.text_id) if task.text_id is not None else None


def _end(connection: Connection, task: Task, submission_id: str, now: datetime, **values: Any) -> Task:
    ended = {"state": SUBMITTED, "submission_id": submission_id, "ended_at": now, "seen_at": now, **values}
    connection.execute(tasks.update().where(tasks.c.task_id == task.task_id).values(**ended))
    connection.execute(drafts.delete().where(drafts.c.task_id == task.task_id))
    return record_of(Task, connection.execute(sa.select(tasks).where(tasks.c.task_id == task.task_id)).one())
