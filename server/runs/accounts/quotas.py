"""Limits of participants per split, checked in the writing transaction, so that no race can exceed them."""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from datetime import UTC, datetime
from typing import Any
from uuid import uuid4

import sqlalchemy as sa
from sqlalchemy.engine import Connection

from arramon_server.errors import BadInput, NotFound, OverQuota
from arramon_server.per_split import MAX_LIMIT
from arramon_server.runs.accounts.accounts import ANONYMOUS_NAME
from arramon_server.runs.accounts.callers import ANONYMOUS, Caller, Role
from arramon_server.runs.accounts.usage import (
    DAY,
    ReadQuery,
    Usage,
    counts_in_total,
    counts_today,
    creation_time,
    latest_runs,
    open_streams,
    runs_with_streams,
    unfinished_condition,
    usage_of,
)
from arramon_server.runs.storage import tables
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.records import Run
from arramon_server.runs.storage.run_activity import UNPLAYED_MINUTES

NAMED = 5
"""Maximum number of runs that an error message names."""


@dataclass(frozen=True, slots=True)
class Quota:
    """Limits of a participant on a split; 0 for no limit.

    Attributes:
        runs_per_day: runs created in any 24 hours.
        runs_in_all: runs created in total.
        runs_at_once: unfinished runs at the same time.
        streams_at_once: open streams at the same time.
    """

    runs_per_day: int = 0
    runs_in_all: int = 0
    runs_at_once: int = 0
    streams_at_once: int = 0


LIMITS = tuple(field.name for field in fields(Quota))

NO_QUOTA = Quota()

OPEN_QUOTA = Quota(runs_per_day=200, runs_at_once=20, streams_at_once=64)
"""Default limits on a split that is not hidden: more than careful work needs, less than a flood."""

HIDDEN_QUOTA = Quota(runs_per_day=3, runs_at_once=3, streams_at_once=64)
"""Default limits on a hidden split: every run reveals a little of it."""


class DefaultQuotas:
    """Limits of callers for whom the host has made no override.

    Callers without a token, on a server for one machine, have only the limits that the host sets: they are one user.

    Args:
        settings: the host's settings, with one field of each name in `LIMITS`.
        hidden: names of the hidden splits.
    """

    def __init__(self, settings: Any, hidden: Collection[str]) -> None:
        self._settings = settings
        self._hidden = frozenset(hidden)

    def __call__(self, caller: Caller, split: str) -> Quota:
        """Return the limits of a caller on a split."""
        is_own_machine = caller.account is None and self._settings.is_for_own_machine
        quota = NO_QUOTA if is_own_machine else HIDDEN_QUOTA if split in self._hidden else OPEN_QUOTA
        given = {name: getattr(self._settings, name).of(split) for name in LIMITS}
        return replace(quota, **{name: limit for name, limit in given.items() if limit is not None})


class Quotas:
    """Limits and usage of all participants. Thread-safe.

    All callers without a token share one quota, as the server cannot distinguish them. Hosts have no limits.

    Args:
        database: storage of quotas, runs and streams.
        default: returns the limits of a caller on a split where the host has made no override.
    """

    def __init__(self, database: Database, default: Callable[[Caller, str], Quota]) -> None:
        self._database = database
        self._default = default

    def admit_run(self, connection: Connection, caller: Caller, split: str) -> None:
        """Check that a caller may create another run, in the transaction that writes the run.

        Raises:
            OverQuota: if a limit is reached.
        """
        read = _query_function(connection)
        quota = self._limits_of(read, caller, split)
        if not any((quota.runs_per_day, quota.runs_in_all, quota.runs_at_once)):
            return
        _lock_account(connection, caller.account)
        use = usage_of(read, caller.account, split)
        have = f"{_who(caller)} have on split {split!r}"

        def runs_text(count: int, noun: str, which: sa.ColumnElement[bool], when: str = "") -> str:
            runs = f" ({_listed(latest_runs(read, caller.account, split, which, NAMED), count)})"
            return _number(count, noun) + when + (runs if caller.may_list else "")

        if 0 < quota.runs_in_all <= use.runs:
            counted = runs_text(use.runs, "run", counts_in_total())
            raise OverQuota(f"{have} {counted}; the limit is {quota.runs_in_all} in total")
        if 0 < quota.runs_at_once <= use.running:
            advice = (
                "so play it to its end (`arramon-client --resume RUN`) or cancel it (`arramon-client cancel RUN`)"
                if caller.may_list
                else f"and one that no client begins to play ends after {UNPLAYED_MINUTES} minutes; "
                "with a token, for which you can ask the host, you have a limit of your own"
            )
            unfinished = runs_text(use.running, "unfinished run", unfinished_condition())
            raise OverQuota(
                f"{have} {unfinished}; the limit is {quota.runs_at_once} "
                f"at once: the next is possible when one of them has ended, {advice}"
            )
        if 0 < quota.runs_per_day <= use.runs_today:
            following = creation_time(read, caller.account, split, quota.runs_per_day) + DAY
            counted = runs_text(use.runs_today, "run", counts_today(), " of the last 24 hours")
            raise OverQuota(
                f"{have} {counted}; the limit is {quota.runs_per_day}: "
                f"the next is possible at {following:%Y-%m-%d %H:%M:%S} UTC"
            )

    def open_stream(self, caller: Caller, run: Run, player: str, worker: str) -> str:
        """Register a new stream, and return its id. It replaces an older stream of the same run and player.

        Raises:
            OverQuota: if the limit of open streams is reached. Streams of dead workers do not count.
        """
        table, workers, stream_id = tables.streams, tables.workers, uuid4().hex
        with self._database.write() as connection:
            read = _query_function(connection)
            limit = self._limits_of(read, caller, run.split).streams_at_once
            if limit:
                _lock_account(connection, run.account)
            replaced = sa.and_(table.c.run_id == run.run_id, table.c.player == player)
            forgotten = table.c.worker.not_in(sa.select(workers.c.worker_id))
            connection.execute(table.delete().where(replaced | forgotten))
            count = open_streams(read, run.account, run.split, self._database.now) if limit else 0
            if 0 < limit <= count:
                playing = runs_with_streams(read, run.account, run.split, self._database.now, NAMED + 1)
                # Knowing the id of an anonymous run suffices to play it: a public server does not reveal any.
                of = f" of {_listed(playing[:NAMED], len(playing))}" if caller.may_list else ""
                raise OverQuota(
                    f"{_who(caller)} have on split {run.split!r} {_number(count, 'open stream')}{of}; "
                    f"the limit is {limit} at once: the next is possible when one is closed, by itself if its client "
                    "vanished"
                )
            row = {"stream_id": stream_id, "run_id": run.run_id, "player": player, "worker": worker}
            connection.execute(table.insert(), [{**row, "opened_at": datetime.now(UTC)}])
        return stream_id

    def close_stream(self, stream_id: str) -> None:
        """Remove a stream that was closed or replaced."""
        table = tables.streams
        with self._database.write() as connection:
            connection.execute(table.delete().where(table.c.stream_id == stream_id))

    def limits_and_usage(self, caller: Caller, split: str) -> tuple[Quota, Usage]:
        """Return the limits of a caller on a split, and the usage that counts against them."""
        read = self._database.read
        streams = open_streams(read, caller.account, split, self._database.now)
        return self._limits_of(read, caller, split), replace(usage_of(read, caller.account, split), streams=streams)

    def set(self, participant: str, split: str, limits: Mapping[str, int | None]) -> None:
        """Override limits of a participant, or of all anonymous callers, on a split.

        Args:
            participant: name of the participant; "anonymous" for callers without a token.
            split: name of the split.
            limits: values by field name of `Quota`; None restores the default.

        Raises:
            BadInput: for a limit out of range.
            NotFound: if there is no such participant.
        """
        for name, limit in limits.items():
            if limit is not None and not 0 <= limit <= MAX_LIMIT:
                raise BadInput(f"{name} is {limit}, expected 0 (no limit) to {MAX_LIMIT}")
        table = tables.quotas
        key = (table.c.participant == participant) & (table.c.split == split)
        with self._database.write() as connection:
            _lock_account(connection, participant)
            _check_participant(connection, participant)
            if not connection.execute(sa.select(table).where(key)).all():
                connection.execute(table.insert(), [{"participant": participant, "split": split}])
            connection.execute(table.update().where(key).values(dict(limits)))

    def of(self, participant: str, split: str) -> Quota:
        """Return the limits of a participant, or of "anonymous" callers, on a split.

        Raises:
            NotFound: if there is no such participant.
        """
        table = tables.participants
        rows = self._database.read(sa.select(table).where(table.c.participant == participant))
        if not rows and participant != ANONYMOUS_NAME:
            raise _no_participant(participant)
        caller = ANONYMOUS if participant == ANONYMOUS_NAME else Caller(Role(rows[0].role), participant)
        return self._limits_of(self._database.read, caller, split)

    def overrides(self) -> Iterator[tuple[str, str, Quota]]:
        """Yield participant, split and limits of all overrides."""
        table = tables.quotas
        for row in self._database.read(sa.select(table).order_by(table.c.participant, table.c.split)):
            yield row.participant, row.split, self.of(row.participant, row.split)

    def _limits_of(self, read: ReadQuery, caller: Caller, split: str) -> Quota:
        if caller.role is Role.HOST:
            return Quota()
        table = tables.quotas
        key = (table.c.participant == (caller.account or ANONYMOUS_NAME), table.c.split == split)
        rows = read(sa.select(table).where(*key))
        found = {name: rows[0]._mapping[name] for name in LIMITS} if rows else {}
        exceptions = {name: limit for name, limit in found.items() if limit is not None}
        return replace(self._default(caller, split), **exceptions)


def _query_function(connection: Connection) -> ReadQuery:
    return lambda query: connection.execute(query).all()


def _check_participant(connection: Connection, participant: str) -> None:
    table = tables.participants
    if connection.execute(sa.select(table).where(table.c.participant == participant)).all():
        return
    if participant != ANONYMOUS_NAME:
        raise _no_participant(participant)
    row = {"participant": ANONYMOUS_NAME, "role": Role.ANONYMOUS.value, "created_at": datetime.now(UTC)}
    connection.execute(table.insert(), [row])


def _no_participant(name: str) -> NotFound:
    return NotFound(f"there is no participant {name!r}; `arramon-server token list` shows them")


def _lock_account(connection: Connection, account: str | None) -> None:
    """Lock an account until the transaction ends. SQLite needs no lock: it has one writer at a time."""
    if connection.dialect.name == "postgresql":
        key = sa.func.hashtextextended(f"arramon quota {account or ANONYMOUS_NAME}", 0)
        connection.execute(sa.select(sa.func.pg_advisory_xact_lock(key)))


def _who(caller: Caller) -> str:
    return "you" if caller.account is not None else "all callers without a token together"


def _listed(run_ids: Sequence[str], count: int) -> str:
    return ", ".join(run_ids) + (" and others" if count > len(run_ids) else "")


def _number(count: int, noun: str) -> str:
    return f"{count} {noun}{'s' * (count != 1)}"
