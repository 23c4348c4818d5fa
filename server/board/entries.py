"""What is published: the table of entries, with what each run came to."""

import hashlib
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from functools import lru_cache
from typing import Any

import sqlalchemy as sa
from sqlalchemy.engine import Row

from server.board.standings import Rows, Seal
from server.errors import NotFound
from server.runs import tables
from server.runs.database import Database, utc
from server.runs.journal import run_of
from server.runs.records import Progress, Run
from server.scoring.aggregate import Interval

_KEPT = 2048
"""Runs whose scores are kept in memory, about 10 KB each."""


@dataclass(frozen=True, slots=True)
class Scores:
    """What a run came to. A run that is over does not change, nor does this."""

    progress: Progress
    rows: Rows
    signature: str


@dataclass(frozen=True, slots=True)
class Published:
    """A run that is, or was, on the leaderboard.

    Attributes:
        withdrawn_at: None while it is listed.
        withdrawn_by_host: whether it was the host who took it off.
    """

    run: Run
    published_at: datetime
    note: str
    withdrawn_at: datetime | None
    withdrawn_by_host: bool


class Entries:
    """All entries. Safe to use from several threads.

    Args:
        database: where they are kept.
    """

    def __init__(self, database: Database) -> None:
        self._database = database
        self._scores = lru_cache(_KEPT)(self._read_scores)

    def find(self, run_id: str) -> Published | None:
        """The entry of a run, withdrawn or not; None where it was never published."""
        rows = self._database.read(_ENTRIES.where(tables.entries.c.run_id == run_id))
        return _published(rows[0]) if rows else None

    def listed(self, split: str, language: str | None = None) -> list[Published]:
        """The entries of a split that are not withdrawn, in one language or in all."""
        query = _ENTRIES.where(tables.entries.c.withdrawn_at.is_(None), tables.runs.c.split == split)
        if language is not None:
            query = query.where(tables.runs.c.language == language)
        return [_published(row) for row in self._database.read(query)]

    def stamp(self) -> tuple[int, int]:
        """Something that is another one after every change of what is published."""
        table = tables.entries
        query = sa.select(
            sa.func.count().label("entries"), sa.func.coalesce(sa.func.sum(table.c.revision), 0).label("revisions")
        )
        row = self._database.read(query.select_from(table))[0]
        return row.entries, int(row.revisions)

    def languages(self) -> set[tuple[str, str]]:
        """Of which splits, and in which of their languages, there are entries that are not withdrawn."""
        query = sa.select(tables.runs.c.split, tables.runs.c.language).distinct().join_from(tables.entries, tables.runs)
        return {(row.split, row.language) for row in self._database.read(query.where(_LISTED))}

    def scores(self, run_id: str) -> Scores:
        """What a run came to whose entry there is.

        Raises:
            NotFound: if there is no entry of that run.
        """
        return self._scores(run_id)

    def seal(self, run_id: str) -> Seal | None:
        """By which a run's receipt can be told; None where there is none."""
        rows = self._database.read(sa.select(tables.receipts).where(tables.receipts.c.run_id == run_id))
        return Seal(hashlib.sha256(rows[0].payload).digest(), rows[0].public_key) if rows else None

    def publish(self, run_id: str, note: str, scores: Scores, *, by_host: bool) -> bool:
        """Puts a run on the leaderboard, again where it was withdrawn; where it is listed, its note is renewed.

        Returns whether that was done: what a host has withdrawn is published by a host alone, and asked in the same
        statement, or a host's withdrawal could come to nothing by a publication that began before it.

        Raises:
            TakenOver: if another process has published it at the same time.
        """
        table = tables.entries
        now = datetime.now(UTC)
        again = sa.case((table.c.withdrawn_at.is_(None), table.c.published_at), else_=now)
        values = {
            "note": note,
            "published_at": again,
            "withdrawn_at": None,
            "withdrawn_by_host": False,
            "revision": table.c.revision + 1,
        }
        with self._database.write() as connection:
            mine = table.c.run_id == run_id
            may = sa.true() if by_host else table.c.withdrawn_by_host.is_(False)
            if connection.execute(table.update().where(mine, may).values(values)).rowcount:
                return True
            if connection.execute(sa.select(table.c.run_id).where(mine)).all():
                return False
            row = {"run_id": run_id, "published_at": now, "note": note, "scores": _written(scores)}
            connection.execute(table.insert().values(row))
            return True

    def withdraw(self, run_id: str, *, by_host: bool) -> None:
        """Takes a run off the leaderboard; its row stays. A host may do so to one that is off it already."""
        table = tables.entries
        values = {
            "withdrawn_at": datetime.now(UTC),
            "withdrawn_by_host": by_host,
            "revision": table.c.revision + 1,
        }
        with self._database.write() as connection:
            may = sa.true() if by_host else _LISTED
            connection.execute(table.update().where(table.c.run_id == run_id, may).values(values))

    def _read_scores(self, run_id: str) -> Scores:
        query = sa.select(tables.entries.c.scores).where(tables.entries.c.run_id == run_id)
        rows = self._database.read(query)
        if not rows:
            raise NotFound(f"there is no run {run_id!r} on the leaderboard")
        return _read(rows[0].scores)


_LISTED = tables.entries.c.withdrawn_at.is_(None)

_ENTRIES = sa.select(
    tables.runs,
    *(tables.entries.c[name] for name in ("published_at", "note", "withdrawn_at", "withdrawn_by_host")),
).join_from(tables.entries, tables.runs)


def _published(row: Row[Any]) -> Published:
    published_at, withdrawn_at = utc(row.published_at), utc(row.withdrawn_at)
    assert published_at is not None
    return Published(run_of(row), published_at, row.note, withdrawn_at, row.withdrawn_by_host)


def _written(scores: Scores) -> dict[str, Any]:
    rows = {
        row: {metric: [value.mean, value.low, value.high] for metric, value in values.items()}
        for row, values in scores.rows.items()
    }
    return {"progress": asdict(scores.progress), "rows": rows, "signature": scores.signature}


def _read(written: Mapping[str, Any]) -> Scores:
    kept = written["progress"]  # by this release or, in a database that came along, by another one
    known = {name: kept[name] for name in Progress.__slots__ if name in kept}
    progress = Progress(**{**known, "images": tuple(known["images"])})
    rows = {
        row: {metric: Interval(*numbers) for metric, numbers in values.items()}
        for row, values in written["rows"].items()
    }
    return Scores(progress, rows, written["signature"])
