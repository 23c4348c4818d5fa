"""How much a participant may do on a split: looked up where it is written, so that nobody slips in."""

from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, fields, replace
from datetime import UTC, datetime
from typing import Any
from uuid import uuid4

import sqlalchemy as sa
from sqlalchemy.engine import Connection

from server.errors import BadInput, NotFound, OverQuota
from server.runs import tables
from server.runs.accounts import NOBODY
from server.runs.callers import ANONYMOUS, Caller, Role
from server.runs.database import Database
from server.runs.records import Run
from server.runs.usage import DAY, Ask, Use, created, open_streams, use_of

MOST = 1_000_000_000
"""That a limit can be."""


@dataclass(frozen=True, slots=True)
class Quota:
    """What a participant may do on a split; 0 for any number.

    Attributes:
        runs_per_day: that they may create in any 24 hours.
        runs_in_all: that they may create.
        runs_at_once: of theirs that may be unfinished.
        streams_at_once: over which they may play.
    """

    runs_per_day: int = 0
    runs_in_all: int = 0
    runs_at_once: int = 0
    streams_at_once: int = 0

    @classmethod
    def of_settings(cls, settings: Any) -> "Quota":
        """What a host's settings give everyone: they have the same names."""
        return cls(**{name: getattr(settings, name) for name in LIMITS})


LIMITS = tuple(field.name for field in fields(Quota))


class Quotas:
    """The limits of everyone, and what counts against them. Safe to use from several threads.

    Those without a token share one quota: the server cannot tell them apart. Hosts have no limits.

    Args:
        database: where runs and streams are kept.
        default: holds where nothing else was set.
    """

    def __init__(self, database: Database, default: Quota) -> None:
        self._database = database
        self._default = default

    def admit_run(self, connection: Connection, caller: Caller, split: str) -> None:
        """To be called in the transaction that then writes a new run.

        Raises:
            OverQuota: if the caller may have no further one.
        """
        ask = _within(connection)
        quota = self._limits_of(ask, caller, split)
        if not any((quota.runs_per_day, quota.runs_in_all, quota.runs_at_once)):
            return
        _hold(connection, caller.account)
        use = use_of(ask, caller.account, split)
        have = f"{_who(caller)} have on split {split!r}"
        if 0 < quota.runs_in_all <= use.runs:
            raise OverQuota(f"{have} {_number(use.runs, 'run')}, and {quota.runs_in_all} in all are allowed")
        if 0 < quota.runs_at_once <= use.running:
            raise OverQuota(
                f"{have} {_number(use.running, 'unfinished run')}, and {quota.runs_at_once} at once are allowed: "
                "the next is possible when one of them is over, so play it to its end, or cancel it"
            )
        if 0 < quota.runs_per_day <= use.runs_today:
            following = created(ask, caller.account, split, quota.runs_per_day) + DAY
            raise OverQuota(
                f"{have} {_number(use.runs_today, 'run')} of the last 24 hours, and {quota.runs_per_day} are allowed: "
                f"the next is possible at {following:%Y-%m-%d %H:%M:%S} UTC"
            )

    def open_stream(self, caller: Caller, run: Run, player: str, worker: str) -> str:
        """Counts a stream that comes in, and returns its id. It takes the place of an older one of the same player.

        Raises:
            OverQuota: if there are as many as may be. Those that a dead worker held do not count.
        """
        table, workers, stream_id = tables.streams, tables.workers, uuid4().hex
        with self._database.write() as connection:
            ask = _within(connection)
            limit = self._limits_of(ask, caller, run.split).streams_at_once
            if limit:
                _hold(connection, run.account)
            replaced = sa.and_(table.c.run_id == run.run_id, table.c.player == player)
            forgotten = table.c.worker.not_in(sa.select(workers.c.worker_id))
            connection.execute(table.delete().where(replaced | forgotten))
            count = open_streams(ask, run.account, run.split, self._database.now) if limit else 0
            if 0 < limit <= count:
                raise OverQuota(
                    f"{_who(caller)} have on split {run.split!r} {_number(count, 'open stream')}, and {limit} at once "
                    "are allowed: the next is possible when one is closed, by itself if its client vanished"
                )
            row = {"stream_id": stream_id, "run_id": run.run_id, "player": player, "worker": worker}
            connection.execute(table.insert(), [{**row, "opened_at": datetime.now(UTC)}])
        return stream_id

    def close_stream(self, stream_id: str) -> None:
        """A stream has gone, or was replaced."""
        table = tables.streams
        with self._database.write() as connection:
            connection.execute(table.delete().where(table.c.stream_id == stream_id))

    def standing(self, caller: Caller, split: str) -> tuple[Quota, Use]:
        """A caller's limits on a split, and what counts against them."""
        ask = self._database.read
        streams = open_streams(ask, caller.account, split, self._database.now)
        return self._limits_of(ask, caller, split), replace(use_of(ask, caller.account, split), streams=streams)

    def set(self, participant: str, split: str, limits: Mapping[str, int | None]) -> None:
        """Gives a participant, or all the anonymous, other limits on a split.

        Args:
            participant: by name; "anonymous" for those without a token.
            split: by name.
            limits: some of those of `Quota`; None for the default again.

        Raises:
            BadInput: for a limit out of range.
            NotFound: if there is no such participant.
        """
        for name, limit in limits.items():
            if limit is not None and not 0 <= limit <= MOST:
                raise BadInput(f"{name} is {limit}, expected 0 (any number) to {MOST}")
        table = tables.quotas
        key = (table.c.participant == participant) & (table.c.split == split)
        with self._database.write() as connection:
            _hold(connection, participant)
            _check_participant(connection, participant)
            if not connection.execute(sa.select(table).where(key)).all():
                connection.execute(table.insert(), [{"participant": participant, "split": split}])
            connection.execute(table.update().where(key).values(dict(limits)))

    def of(self, participant: str, split: str) -> Quota:
        """The limits of a participant, or of all the anonymous.

        Raises:
            NotFound: if there is no such participant.
        """
        table = tables.participants
        rows = self._database.read(sa.select(table).where(table.c.participant == participant))
        if not rows and participant != NOBODY:
            raise _no_participant(participant)
        caller = Caller(Role(rows[0].role), participant) if rows else ANONYMOUS
        return self._limits_of(self._database.read, caller, split)

    def exceptions(self) -> Iterator[tuple[str, str, Quota]]:
        """Participant, split and limits, wherever others than the default were set."""
        table = tables.quotas
        for row in self._database.read(sa.select(table).order_by(table.c.participant, table.c.split)):
            yield row.participant, row.split, self._overridden(row._mapping)

    def _limits_of(self, ask: Ask, caller: Caller, split: str) -> Quota:
        if caller.role is Role.HOST:
            return Quota()
        table = tables.quotas
        own = sa.select(table).where(table.c.participant == (caller.account or NOBODY), table.c.split == split)
        rows = ask(own)
        return self._overridden(rows[0]._mapping) if rows else self._default

    def _overridden(self, row: Mapping[Any, Any]) -> Quota:
        return Quota(**{**asdict(self._default), **{name: row[name] for name in LIMITS if row[name] is not None}})


def _within(connection: Connection) -> Ask:
    return lambda query: connection.execute(query).all()


def _check_participant(connection: Connection, participant: str) -> None:
    table = tables.participants
    if connection.execute(sa.select(table).where(table.c.participant == participant)).all():
        return
    if participant != NOBODY:
        raise _no_participant(participant)
    row = {"participant": NOBODY, "role": Role.ANONYMOUS.value, "created_at": datetime.now(UTC)}
    connection.execute(table.insert(), [row])


def _no_participant(name: str) -> NotFound:
    return NotFound(f"there is no participant {name!r}; `arramon-server token list` shows them")


def _hold(connection: Connection, account: str | None) -> None:
    """Whoever holds the same account waits until this transaction ends. SQLite has one writer at a time as it is."""
    if connection.dialect.name == "postgresql":
        key = sa.func.hashtextextended(f"arramon quota {account or NOBODY}", 0)
        connection.execute(sa.select(sa.func.pg_advisory_xact_lock(key)))


def _who(caller: Caller) -> str:
    return "you" if caller.account is not None else "those without a token together"


def _number(count: int, noun: str) -> str:
    return f"{count} {noun}{'s' * (count != 1)}"
