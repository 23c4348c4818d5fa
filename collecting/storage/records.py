"""Rows of the tables of collections, as dataclasses, and the names of their states."""

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any, TypeVar

import sqlalchemy as sa
from sqlalchemy.engine import Row

from arramon_collecting.settings import Settings
from arramon_server.runs.storage.database import Database, utc

WRITE_KIND, REVIEW_KIND = "write", "review"
"""Kinds of collections: people write and verify, or hosts review the generated texts of a split."""

RUNNING, PAUSED, CLOSED = "running", "paused", "closed"
"""States of a collection."""

QUEUED, SENDING, SENT, FAILED = "queued", "sending", "sent", "failed"
"""States of a mail."""

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


def first_record(database: Database, kind: type[T], query: sa.Select[Any]) -> T | None:
    """Return the first row that a query finds as one of these dataclasses; None if it finds none."""
    rows = database.read(query)
    return record_of(kind, rows[0]) if rows else None


def _value(value: Any) -> Any:
    if isinstance(value, datetime):
        return utc(value)
    return _frozen(value) if isinstance(value, list) else value


def _frozen(value: Any) -> Any:
    """Return a JSON value with its lists, but not those within objects, as tuples."""
    return tuple(map(_frozen, value)) if isinstance(value, Sequence) and not isinstance(value, str) else value
