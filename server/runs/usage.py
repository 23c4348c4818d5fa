"""What participants have done on a split, as it counts against their limits: looked up, and never written."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import Any, TypeAlias

import sqlalchemy as sa
from sqlalchemy.engine import Row

from server.runs import tables
from server.runs.causes import SERVER_FAULT
from server.runs.database import utc
from server.runs.records import LEASE, RUNNING

DAY = timedelta(days=1)

Ask: TypeAlias = Callable[[sa.Select[Any]], Sequence[Row[Any]]]
"""Where a query goes: into a transaction, or to the database as it is."""


@dataclass(frozen=True, slots=True)
class Use:
    """What a participant has done on a split; each counts against a limit of `Quota`. The server's faults do not."""

    runs_today: int
    runs: int
    running: int
    streams: int


def use_of(ask: Ask, account: str | None, split: str) -> Use:
    """All but the streams."""
    runs, since = tables.runs, datetime.now(UTC) - DAY
    counted: dict[str, sa.ColumnElement[bool]] = {
        "today": _counts() & (runs.c.created_at > since),
        "in_all": _counts(),
        "running": runs.c.state == RUNNING,
    }
    query: Any = sa.select(*(sa.func.count().filter(condition).label(name) for name, condition in counted.items()))
    row = ask(query.where(_of(account, split)))[0]
    return Use(row.today, row.in_all, row.running, 0)


def created(ask: Ask, account: str | None, split: str, number: int) -> datetime:
    """When the last but `number - 1` of the runs that count was created."""
    runs = tables.runs
    query = sa.select(runs.c.created_at).where(_of(account, split), _counts())
    found = utc(ask(query.order_by(runs.c.created_at.desc()).offset(number - 1).limit(1))[0][0])
    assert found is not None
    return found


def open_streams(ask: Ask, account: str | None, split: str, now: sa.ColumnElement[float]) -> int:
    """How many streams are open. Those that a dead worker held do not count."""
    streams, workers, runs = tables.streams, tables.workers, tables.runs
    query = (
        sa.select(sa.func.count())
        .select_from(streams.join(runs).join(workers, streams.c.worker == workers.c.worker_id))
        .where(_of(account, split), workers.c.seen >= now - LEASE)
    )
    count: int = ask(query)[0][0]
    return count


def _of(account: str | None, split: str) -> sa.ColumnElement[bool]:
    return sa.and_(tables.runs.c.account == account, tables.runs.c.split == split)


def _counts() -> sa.ColumnElement[bool]:
    """Whether a run counts: none of its episodes ended by the server's fault."""
    runs, episodes = tables.runs, tables.episodes
    # Written out, or the databases would not see that the index of these holds all that is looked for.
    by_fault = episodes.c.cause == sa.literal(SERVER_FAULT, literal_execute=True)
    return ~sa.exists().where(episodes.c.run_id == runs.c.run_id, by_fault).correlate(runs)
