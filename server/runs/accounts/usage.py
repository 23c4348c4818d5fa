"""Counts of a participant's runs and streams on a split, for quotas."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import Any, TypeAlias

import sqlalchemy as sa
from sqlalchemy.engine import Row

from arramon_server.runs.storage import tables
from arramon_server.runs.storage.causes import SERVER_FAULT
from arramon_server.runs.storage.database import utc
from arramon_server.runs.storage.records import LEASE, RUNNING

DAY = timedelta(days=1)

ReadQuery: TypeAlias = Callable[[sa.Select[Any]], Sequence[Row[Any]]]
"""Executes a query, in a transaction or directly, and returns its rows."""


@dataclass(frozen=True, slots=True)
class Usage:
    """Usage of a participant on a split; each number counts against a limit of `Quota`.

    Attributes:
        runs_today: runs created in the last 24 hours; those with an episode that ended by SERVER_FAULT do not count.
        runs: runs created in total, pruned ones included, with the same exception.
        running: unfinished runs.
        streams: open streams.
    """

    runs_today: int
    runs: int
    running: int
    streams: int


def usage_of(read: ReadQuery, account: str | None, split: str) -> Usage:
    """Return the usage of an account, with the streams set to 0."""
    counted = {"today": counts_today(), "in_all": counts_in_total(), "running": unfinished_condition()}
    query: Any = sa.select(
        *(sa.func.count().filter(condition).label(name) for name, condition in counted.items()),
        _number_of_pruned(account, split).label("pruned"),
    )
    row = read(query.select_from(tables.runs).where(_of(account, split)))[0]
    return Usage(row.today, row.in_all + row.pruned, row.running, 0)


def _number_of_pruned(account: str | None, split: str) -> sa.ScalarSelect[int]:
    """Return the number of pruned runs that count in total; none of them is of the last 24 hours (see `pruning`)."""
    c = tables.pruned_runs.c
    query: Any = sa.select(sa.func.count()).where(c.account == account, c.split == split, c.had_fault.is_(False))
    found: sa.ScalarSelect[int] = query.scalar_subquery()
    return found


def latest_runs(
    read: ReadQuery, account: str | None, split: str, condition: sa.ColumnElement[bool], limit: int
) -> list[str]:
    """Return the ids of at most `limit` runs that meet a condition, latest first."""
    runs = tables.runs
    query = sa.select(runs.c.run_id).where(_of(account, split), condition)
    return [row.run_id for row in read(query.order_by(runs.c.created_at.desc(), runs.c.run_id.desc()).limit(limit))]


def creation_time(read: ReadQuery, account: str | None, split: str, number: int) -> datetime:
    """Return the creation time of the `number`-th latest run that counts, in UTC; 1 for the latest."""
    runs = tables.runs
    query = sa.select(runs.c.created_at).where(_of(account, split), counts_in_total())
    found = utc(read(query.order_by(runs.c.created_at.desc()).offset(number - 1).limit(1))[0][0])
    assert found is not None
    return found


def open_streams(read: ReadQuery, account: str | None, split: str, now: sa.ColumnElement[float]) -> int:
    """Return the number of open streams. Those of dead workers do not count."""
    query = sa.select(sa.func.count()).select_from(_STREAMS).where(_is_open(account, split, now))
    count: int = read(query)[0][0]
    return count


def runs_with_streams(
    read: ReadQuery, account: str | None, split: str, now: sa.ColumnElement[float], limit: int
) -> list[str]:
    """Return the ids of at most `limit` runs whose streams `open_streams` counts."""
    runs = tables.runs
    query = sa.select(runs.c.run_id).distinct().select_from(_STREAMS).where(_is_open(account, split, now))
    return [row.run_id for row in read(query.order_by(runs.c.run_id).limit(limit))]


def _is_open(account: str | None, split: str, now: sa.ColumnElement[float]) -> sa.ColumnElement[bool]:
    return sa.and_(_of(account, split), tables.workers.c.seen >= now - LEASE)


def _of(account: str | None, split: str) -> sa.ColumnElement[bool]:
    return sa.and_(tables.runs.c.account == account, tables.runs.c.split == split)


def unfinished_condition() -> sa.ColumnElement[bool]:
    """Return the SQL condition that a run is unfinished."""
    return tables.runs.c.state == RUNNING


def counts_today() -> sa.ColumnElement[bool]:
    """Return the SQL condition that a run counts, and was created in the last 24 hours."""
    return counts_in_total() & (tables.runs.c.created_at > datetime.now(UTC) - DAY)


def counts_in_total() -> sa.ColumnElement[bool]:
    """Return the SQL condition that a run counts against the total: none of its episodes ended by SERVER_FAULT."""
    runs, episodes = tables.runs, tables.episodes
    # As a literal: otherwise the databases would not recognise that the partial index covers the query.
    by_fault = episodes.c.cause == sa.literal(SERVER_FAULT, literal_execute=True)
    return ~sa.exists().where(episodes.c.run_id == runs.c.run_id, by_fault).correlate(runs)


_STREAMS = tables.streams.join(tables.runs).join(tables.workers, tables.streams.c.worker == tables.workers.c.worker_id)
