"""Storage of epochs of hidden splits, each opened, closed and revealed once, in this order."""

import hashlib
import json
from dataclasses import dataclass
from datetime import UTC, datetime
from enum import StrEnum
from typing import Any

import sqlalchemy as sa
from sqlalchemy.engine import Connection, Row

from arramon_server.errors import Conflict, NotFound, quoted
from arramon_server.runs.storage import tables
from arramon_server.runs.storage.database import Database, utc
from arramon_server.runs.storage.records import RUNNING

_EPOCHS = tables.epochs


class EpochState(StrEnum):
    """State of an epoch."""

    OPEN = "open"
    """Runs are accepted."""
    CLOSED = "closed"
    """No new runs are accepted; those that were begun may be played to their end."""
    REVEALED = "revealed"
    """No run is being played, and the secret is public."""


@dataclass(frozen=True, slots=True)
class EpochRecord:
    """One epoch of a hidden split.

    Attributes:
        split: name of its split.
        statement: the host's statement as written, to which it committed.
        opened_at, closed_at, revealed_at: times in UTC; None until then.
        secret: None until it is revealed.
    """

    split: str
    statement: bytes
    opened_at: datetime
    closed_at: datetime | None = None
    revealed_at: datetime | None = None
    secret: str | None = None

    @property
    def state(self) -> EpochState:
        """Current state."""
        if self.revealed_at is not None:
            return EpochState.REVEALED
        return EpochState.OPEN if self.closed_at is None else EpochState.CLOSED

    @property
    def commitment(self) -> bytes:
        """SHA-256 of the statement, 32 bytes."""
        return hashlib.sha256(self.statement).digest()


class EpochStore:
    """All epochs in a database. Thread-safe.

    Args:
        database: storage of the epochs.
    """

    def __init__(self, database: Database) -> None:
        self._database = database

    def all(self) -> list[EpochRecord]:
        """Return all epochs, the latest opened first."""
        query = sa.select(_EPOCHS).order_by(_EPOCHS.c.opened_at.desc(), _EPOCHS.c.split.desc())
        return [_record(row) for row in self._database.read(query)]

    def find(self, split: str) -> EpochRecord | None:
        """Return the epoch of a split; None if the split is not an epoch."""
        rows = self._database.read(sa.select(_EPOCHS).where(_EPOCHS.c.split == split))
        return _record(rows[0]) if rows else None

    def of(self, split: str) -> EpochRecord:
        """Return the epoch of a split.

        Raises:
            NotFound: if there is none; the message names the existing ones.
        """
        found = self.find(split)
        if found is None:
            there = ", ".join(record.split for record in self.all()) or "none"
            raise NotFound(f"there is no epoch {quoted(split)}; there are {there}")
        return found

    def open(self, split: str, statement: bytes) -> EpochRecord:
        """Open an epoch.

        Raises:
            Conflict: if there is one of that name.
        """
        record = EpochRecord(split, statement, _now())
        with self._database.write() as connection:
            if connection.execute(sa.select(_EPOCHS.c.split).where(_EPOCHS.c.split == split)).first():
                raise Conflict(f"there is an epoch {split!r} already; an epoch is opened once")
            row = {"split": split, "statement": statement, "opened_at": record.opened_at}
            connection.execute(_EPOCHS.insert(), [row])
        return record

    def close(self, split: str) -> list[str]:
        """Close an epoch to new runs, and return the ids of the runs that are still being played.

        Raises:
            NotFound: if there is no such epoch.
            Conflict: if it is closed already.
        """
        self.of(split)
        with self._database.write() as connection:
            record = _locked(connection, split)
            if record.closed_at is not None:
                raise Conflict(f"the epoch {split!r} was closed on {record.closed_at:%Y-%m-%d at %H:%M} UTC")
            connection.execute(_EPOCHS.update().where(_EPOCHS.c.split == split).values(closed_at=_now()))
            return _running(connection, split)

    def running(self, split: str) -> list[str]:
        """Return the ids of the runs on a split that are being played."""
        return [row.run_id for row in self._database.read(_of_running(split))]

    def reveal(self, split: str, secret: str) -> EpochRecord:
        """Publish the secret of a closed epoch.

        Args:
            split: name of its split.
            secret: the secret of the statement, which the caller has checked.

        Raises:
            NotFound: if there is no such epoch.
            Conflict: if it is open or revealed already, or runs on it are being played.
        """
        self.of(split)
        with self._database.write() as connection:
            record = _locked(connection, split)
            if record.closed_at is None:
                raise Conflict(f"the epoch {split!r} is open; close it first (`arramon-server epoch close {split}`)")
            if record.revealed_at is not None:
                raise Conflict(f"the secret of the epoch {split!r} is revealed already")
            if running := _running(connection, split):
                raise Conflict(
                    f"{len(running)} runs on the epoch {split!r} are still being played: {', '.join(running[:10])}"
                    f"{' and others' if len(running) > 10 else ''}; wait for their end, or forfeit what they have not "
                    "played (`--forfeit`)"
                )
            values = {"revealed_at": _now(), "secret": secret}
            connection.execute(_EPOCHS.update().where(_EPOCHS.c.split == split).values(values))
        return self.of(split)


def check_open(connection: Connection, split: str, data_hash: str) -> None:
    """Check, in the transaction that creates a run, that its split is no epoch, or is an open one with unchanged data.

    Raises:
        Conflict: if the epoch is closed, or the split's data is not what the host committed to.
    """
    rows = connection.execute(sa.select(_EPOCHS).where(_EPOCHS.c.split == split).with_for_update(read=True)).all()
    if not rows:
        return
    record = _record(rows[0])
    if record.closed_at is not None:
        raise Conflict(
            f"the epoch {split!r} was closed on {record.closed_at:%Y-%m-%d at %H:%M} UTC, and no runs begin on it; "
            "play an open epoch"
        )
    if json.loads(record.statement)["data_hash"] != data_hash:
        raise Conflict(
            f"the data of the split {split!r}, {data_hash[:12]}, is not what the host committed to when it opened the "
            "epoch; tell the server's host"
        )


def _locked(connection: Connection, split: str) -> EpochRecord:
    query = sa.select(_EPOCHS).where(_EPOCHS.c.split == split).with_for_update()
    return _record(connection.execute(query).one())


def _running(connection: Connection, split: str) -> list[str]:
    return [row.run_id for row in connection.execute(_of_running(split))]


def _of_running(split: str) -> sa.Select[Any]:
    table = tables.runs
    query = sa.select(table.c.run_id).where(table.c.split == split, table.c.state == RUNNING)
    return query.order_by(table.c.created_at, table.c.run_id)


def _record(row: Row[Any]) -> EpochRecord:
    opened_at = utc(row.opened_at)
    assert opened_at is not None
    return EpochRecord(row.split, row.statement, opened_at, utc(row.closed_at), utc(row.revealed_at), row.secret)


def _now() -> datetime:
    return datetime.now(UTC)
