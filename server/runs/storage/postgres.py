"""PostgreSQL connections for the journal that fail within seconds if the database cannot be reached.

The engine queries its database on the event loop that also serves the streams, so none of its calls may hang.
"""

import time
from collections.abc import Generator
from typing import Any, TypeVar

import psycopg
import sqlalchemy as sa
from sqlalchemy.engine import URL, Connection

CONNECT_SECONDS = 3
"""Timeout for establishing a connection."""

ANSWER_SECONDS = 8.0
"""Timeout of a statement. A live PostgreSQL cancels statements and waits for locks earlier than that."""

MIGRATION_SECONDS = 600
"""Timeout of a statement of a migration, and of the wait for a migration by another process."""

FRESH_SECONDS = 0.5
"""Time after its last use during which a connection is assumed to be alive."""

_LOCK = 0x41_72_72_61  # an arbitrary number, the same in all versions of the server

_LIMITS = {"statement_timeout": "6s", "lock_timeout": "4s", "idle_in_transaction_session_timeout": "6s"}
_MIGRATION_LIMITS = {"statement_timeout": "0", "lock_timeout": f"{MIGRATION_SECONDS}s"}

# The operating system detects a connection whose peer vanished silently in about ten seconds.
_TCP = {
    "keepalives": 1,
    "keepalives_idle": 4,
    "keepalives_interval": 2,
    "keepalives_count": 3,
    "tcp_user_timeout": 8000,
}

_T = TypeVar("_T")


class _Connection(psycopg.Connection[Any]):
    """Connection that fails if the database accepts a statement but does not answer in time."""

    answer_seconds = ANSWER_SECONDS

    def wait(self, gen: Generator[Any, Any, _T], *arguments: Any, **named: Any) -> _T:
        return super().wait(self._limited(gen), *arguments, **named)

    def _limited(self, steps: Generator[Any, Any, _T]) -> Generator[Any, Any, _T]:
        until = time.monotonic() + self.answer_seconds
        try:
            wanted = next(steps)
            while True:
                ready = yield wanted  # psycopg also resumes at intervals with nothing ready
                if not ready and time.monotonic() > until:
                    self.pgconn.finish()
                    raise psycopg.OperationalError(f"the database has not answered for {self.answer_seconds:g} s")
                wanted = steps.send(ready)
        except StopIteration as end:
            result: _T = end.value
            return result


class _MigratingConnection(_Connection):
    """Connection for migrations, with a longer timeout."""

    answer_seconds = MIGRATION_SECONDS


def postgres_engine(url: URL, *, fsync: bool, migrating: bool = False) -> sa.Engine:
    """Return an engine that connects to PostgreSQL on first use.

    Args:
        url: URL of the database; libpq settings in its query override the server's own.
        fsync: whether commits are as durable as the database is configured to make them, instead of asynchronous.
        migrating: whether to use the long timeouts of migrations.
    """
    limits = dict(_MIGRATION_LIMITS if migrating else _LIMITS)
    limits |= {"timezone": "UTC"} if fsync else {"timezone": "UTC", "synchronous_commit": "off"}
    kind = _MigratingConnection if migrating else _Connection
    made = sa.create_engine(url, isolation_level="READ COMMITTED", pool_timeout=5)

    @sa.event.listens_for(made, "do_connect")
    def connect(_dialect: object, _record: object, arguments: tuple[Any, ...], named: dict[str, Any]) -> Any:
        given = " ".join(f"-c {name}={value}" for name, value in limits.items())
        options = f"{given} {named.get('options', '')}".strip()
        settings = {"connect_timeout": CONNECT_SECONDS, "application_name": "arramon", **_TCP, **named}
        return kind.connect(*arguments, **{**settings, "options": options})

    @sa.event.listens_for(made, "checkin")
    def put_back(_connection: object, record: Any) -> None:
        record.info["used"] = time.monotonic()

    @sa.event.listens_for(made, "checkout")
    def take(connection: Any, record: Any, _proxy: object) -> None:
        # A recently used connection is not pinged: a ping would take half the time of a query.
        if time.monotonic() - record.info.get("used", time.monotonic()) > FRESH_SECONDS:
            try:
                made.dialect.do_ping(connection)
            except psycopg.Error as error:
                raise sa.exc.DisconnectionError(str(error)) from error  # the pool opens another connection

    return made


def is_alive(connection: Connection, unused: float) -> bool:
    """Return whether a connection, unused for so many seconds, is alive (SQLite: always); invalidate a dead one."""
    driver: Any = connection.connection.driver_connection
    if not isinstance(driver, psycopg.Connection) or unused < FRESH_SECONDS:
        return True
    try:
        dialect: Any = connection.dialect
        return bool(dialect.do_ping(driver))
    except psycopg.Error as error:
        connection.invalidate(error)
        return False


def lock_migrations(connection: Connection) -> None:
    """Wait for the lock of migrations, and hold it until the transaction ends."""
    connection.execute(sa.select(sa.func.pg_advisory_xact_lock(_LOCK)))
