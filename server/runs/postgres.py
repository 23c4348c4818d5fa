"""PostgreSQL as the journal's database: connections on which a database that is gone is an error within seconds.

The engine asks its database on the event loop that also carries the streams, so that none of its calls may hang.
"""

import time
from collections.abc import Generator
from typing import Any, TypeVar

import psycopg
import sqlalchemy as sa
from sqlalchemy.engine import URL, Connection

CONNECT_SECONDS = 3
"""In which a connection must stand."""

ANSWER_SECONDS = 8.0
"""In which a statement must be answered. PostgreSQL gives statements and locks up earlier, where it is alive."""

MIGRATION_SECONDS = 600
"""The same for a migration, and for the wait until another process has done it."""

FRESH_SECONDS = 0.5
"""After its last use, for which a connection is taken to stand."""

_LOCK = 0x41_72_72_61  # any number that all versions of the server share

_LIMITS = {"statement_timeout": "6s", "lock_timeout": "4s", "idle_in_transaction_session_timeout": "6s"}
_MIGRATION_LIMITS = {"statement_timeout": "0", "lock_timeout": f"{MIGRATION_SECONDS}s"}

# A connection whose other end vanished without a word is found out by the system, in about ten seconds.
_TCP = {
    "keepalives": 1,
    "keepalives_idle": 4,
    "keepalives_interval": 2,
    "keepalives_count": 3,
    "tcp_user_timeout": 8000,
}

_T = TypeVar("_T")


class _Connection(psycopg.Connection[Any]):
    """Gives up on a database that takes a question and never answers."""

    answer_seconds = ANSWER_SECONDS

    def wait(self, gen: Generator[Any, Any, _T], *arguments: Any, **named: Any) -> _T:
        return super().wait(self._limited(gen), *arguments, **named)

    def _limited(self, steps: Generator[Any, Any, _T]) -> Generator[Any, Any, _T]:
        until = time.monotonic() + self.answer_seconds
        try:
            wanted = next(steps)
            while True:
                ready = yield wanted  # nothing is ready: psycopg looks in now and then
                if not ready and time.monotonic() > until:
                    self.pgconn.finish()
                    raise psycopg.OperationalError(f"the database has not answered for {self.answer_seconds:g} s")
                wanted = steps.send(ready)
        except StopIteration as end:
            result: _T = end.value
            return result


class _MigratingConnection(_Connection):
    """Is patient, but not for ever."""

    answer_seconds = MIGRATION_SECONDS


def engine(url: URL, *, fsync: bool, migrating: bool = False) -> sa.Engine:
    """Connects to PostgreSQL when it is first asked.

    Args:
        url: with any settings of libpq in its query; these win over the server's own.
        fsync: whether a commit waits until it is on the disk, as the database is set up to do, or not.
        migrating: for migrations, which may take long.
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
        # A connection that stood a moment ago is not asked whether it still does: that is half the time of a question.
        if time.monotonic() - record.info.get("used", time.monotonic()) > FRESH_SECONDS:
            try:
                made.dialect.do_ping(connection)
            except psycopg.Error as error:
                raise sa.exc.DisconnectionError(str(error)) from error  # the pool makes another

    return made


def stands(connection: Connection, unused: float) -> bool:
    """Whether a connection of either database that was not used for so many seconds still stands; closes it if not."""
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
    """Waits until no other process migrates, and keeps others waiting until the transaction ends."""
    connection.execute(sa.select(sa.func.pg_advisory_xact_lock(_LOCK)))
