"""The database behind the journal: opens it, brings it up to date, and turns its errors into the server's."""

import os
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import Any
from urllib.parse import quote

import sqlalchemy as sa
from alembic.util import CommandError
from sqlalchemy import event
from sqlalchemy.engine import URL, Connection, Engine, Row, make_url
from sqlalchemy.exc import ArgumentError, DataError, DBAPIError, IntegrityError, OperationalError
from sqlalchemy.exc import TimeoutError as PoolTimeoutError

from server.errors import BadInput, StorageError, TakenOver
from server.runs import postgres
from server.runs.kept import Kept, Rows
from server.runs.migrations import migrate, newest_revision, revision_of

REST, MAX_REST_SECONDS, QUICK_SECONDS = 4.0, 10.0, 0.5
"""A database that did not fail quickly is not asked again for so many times as long: the streams need the loop."""


class Database:
    """SQLite or PostgreSQL, by URL. Safe to use from several threads, but for `commit`, which belongs to one.

    Args:
        url: `sqlite:////var/lib/arramon/journal.db` or `postgresql://user:password@host/name`.
        fsync: whether a commit waits for the disk (PostgreSQL: as it is set up to). Without, a commit outlives the end
            of any process, but the last ones may be gone after a loss of power; the client plays those steps again.
        clock: this machine's, in seconds since 1970. PostgreSQL has its own, which all hosts share.
        patient: whether statements may take minutes, as when all is carried to another host; a server has no time.
        read_only: whether it is only looked at, with patience: it must be up to date, and stays as it is.

    Raises:
        BadInput: if the URL is of neither.
        StorageError: if the database cannot be opened or written, or a newer server has made it.
    """

    def __init__(
        self,
        url: str,
        *,
        fsync: bool = True,
        clock: Callable[[], float] = time.time,
        patient: bool = False,
        read_only: bool = False,
    ) -> None:
        parsed = _parsed(url)
        self._clock = clock
        self._is_sqlite = parsed.get_backend_name() == "sqlite"
        self._file = (parsed.database or "") if self._is_sqlite else ""
        self._resting, self._reason = 0.0, ""
        if read_only:
            self._connect(_engine(_read_only(parsed), fsync=fsync, patient=True, read_only=True))
            self._check_revision()
            return
        if self._is_sqlite and parsed.database:
            _claim_file(Path(parsed.database))
        migrating = _engine(parsed, fsync=fsync, migrating=True)
        try:
            with self._errors(), migrating.begin() as connection:
                if not self._is_sqlite:
                    postgres.lock_migrations(connection)
                migrate(connection)
        except CommandError as error:
            raise StorageError(
                f"the journal was made by another version of this server: {error}; "
                f"this one knows version {newest_revision()} of the tables, and older ones"
            ) from error
        finally:
            migrating.dispose()
        self._connect(_engine(parsed, fsync=fsync, patient=patient))

    def _connect(self, engine: Engine) -> None:
        self._engine = engine
        reading: dict[str, Any] = {"reading": True} if self._is_sqlite else {"isolation_level": "AUTOCOMMIT"}
        self._reader = self._engine.execution_options(**reading)
        # SQLite: transactions are begun by hand. PostgreSQL: a statement of its own is one.
        self._kept = Kept(engine.connect if self._is_sqlite else self._reader.connect)

    @property
    def now(self) -> sa.ColumnElement[float]:
        """The time in seconds since 1970, for use in a statement: by one clock for all that share the database."""
        if self._is_sqlite:
            return sa.literal(self._clock(), sa.Float)
        return sa.cast(sa.extract("epoch", sa.func.clock_timestamp()), sa.Float)

    def close(self) -> None:
        """Lets the database go."""
        self._kept.drop()
        self._engine.dispose()

    def read(self, query: sa.Select[Any]) -> Sequence[Row[Any]]:
        """The rows that a query finds.

        Raises:
            BadInput: if it asks for what no database can hold.
            StorageError: if the database cannot be read.
        """
        with self._errors(), self._reader.connect() as connection:
            return connection.execute(query).all()

    @contextmanager
    def snapshot(self) -> Iterator[Connection]:
        """A connection to read through that shows everything as it stood at one moment, whatever is written meanwhile.

        Raises:
            StorageError: if the database cannot be read.
        """
        isolated: dict[str, Any] = {"isolation_level": "REPEATABLE READ", "postgresql_readonly": True}
        options: dict[str, Any] = {"reading": True} if self._is_sqlite else isolated
        with self._errors(), self._engine.connect() as connection:
            yield connection.execution_options(**options)

    @contextmanager
    def write(self) -> Iterator[Connection]:
        """A connection to write through: all of it, or nothing where an error leaves the block.

        Raises:
            TakenOver: if a row is there already.
            BadInput: if the database cannot hold what is written.
            StorageError: if the database cannot be written.
        """
        with self._errors(), self._engine.begin() as connection:
            yield connection

    @contextmanager
    def commit(self) -> Iterator[Connection]:
        """As `write`; with SQLite on a connection that is kept, as this is done often."""
        if not self._is_sqlite:  # its pool looks whether a connection still stands
            with self.write() as connection:
                yield connection
            return
        with self._errors(), self._kept.use() as connection, connection.begin():
            yield connection

    def commit_rows(self, statement: sa.Insert, rows: Rows, *, at_once: sa.Executable) -> bool:
        """Inserts rows, all or none, in a transaction of their own; returns whether each found its place.

        Args:
            statement: for one row; used with SQLite.
            rows: what it inserts.
            at_once: the same for all rows, of which each value is a list, and for none if any has no place; used with
                PostgreSQL, where each question takes its time on the way.

        Raises:
            TakenOver: if a row is there already.
            StorageError: if the database cannot be written.
        """
        with self._errors():
            return self._kept.insert(statement, rows) if self._is_sqlite else self._kept.insert_at_once(at_once, rows)

    def _check_revision(self) -> None:
        with self.snapshot() as connection:
            found = revision_of(connection)
        if found != newest_revision():
            raise StorageError(
                f"the journal has the tables of version {found or 'none'}, expected {newest_revision()}; "
                "`arramon-server serve` brings an older one up to date"
            )

    @contextmanager
    def _errors(self) -> Iterator[None]:
        started = time.monotonic()
        if started < self._resting:
            raise StorageError(self._reason)
        try:
            yield
        except IntegrityError as error:
            raise TakenOver(f"the journal holds this already: {error.orig}") from error
        except DataError as error:
            raise BadInput(f"the journal cannot hold this: {error.orig}") from error
        except (DBAPIError, PoolTimeoutError) as error:
            reason = error.orig if isinstance(error, DBAPIError) else error
            self._reason = f"the journal cannot be used: {reason}"
            if "unable to open" in str(reason):
                self._reason += f" {self._file}"
            gone = isinstance(error, OperationalError) and (error.connection_invalidated or error.statement is None)
            if gone and (failed := time.monotonic()) > started + QUICK_SECONDS:
                self._resting = failed + min(REST * (failed - started), MAX_REST_SECONDS)
            raise StorageError(self._reason) from error


def _claim_file(path: Path) -> None:
    """Makes a new database's file its owner's alone, as it will hold more than participants may see."""
    with suppress(OSError):  # what is wrong with the place, SQLite says in its own words
        os.close(os.open(path, os.O_CREAT, 0o600))


def utc(time: datetime | None) -> datetime | None:
    """A time as it was written: SQLite drops its zone."""
    return time.replace(tzinfo=UTC) if time is not None and time.tzinfo is None else time


def _parsed(url: str) -> URL:
    expected = "expected sqlite:///PATH or postgresql://USER:PASSWORD@HOST/NAME"
    try:
        parsed = make_url(url)
    except (ArgumentError, ValueError):  # its message might hold a password
        raise BadInput(f"the journal's URL cannot be read; {expected}") from None
    kind = parsed.drivername.partition("+")[0]
    if kind == "sqlite":
        return parsed
    if kind in ("postgresql", "postgres"):
        return parsed.set(drivername="postgresql+psycopg")
    raise BadInput(f"the journal cannot be kept in {kind!r}; {expected}")


def _read_only(url: URL) -> URL:
    """SQLite's own way to say that a file is to be there, and to be left alone."""
    if url.get_backend_name() != "sqlite":
        return url
    return url.set(database=f"file:{quote(url.database or '')}").update_query_dict({"mode": "ro", "uri": "true"})


def _engine(
    url: URL, *, fsync: bool, migrating: bool = False, patient: bool = False, read_only: bool = False
) -> Engine:
    if url.get_backend_name() != "sqlite":
        return postgres.engine(url, fsync=fsync, migrating=migrating or patient)
    engine = sa.create_engine(url)
    # A migration may make a table anew, and what refers to it must not go with the old one.
    pragmas = {"busy_timeout": "10000", "journal_mode": "WAL", "synchronous": "FULL" if fsync else "NORMAL"}
    pragmas["foreign_keys"] = "OFF" if migrating else "ON"
    if read_only:
        pragmas = {"busy_timeout": "10000"}
    event.listen(engine, "connect", partial(_prepare_sqlite, pragmas))
    event.listen(engine, "begin", _begin_sqlite)
    return engine


def _prepare_sqlite(pragmas: dict[str, str], connection: Any, _record: object) -> None:
    connection.isolation_level = None  # or the driver commits and begins behind SQLAlchemy's back
    for name, value in pragmas.items():
        connection.execute(f"PRAGMA {name}={value}")


def _begin_sqlite(connection: Connection) -> None:
    # A writer takes its lock at once: two that first read and then write would be turned away instead of waiting.
    reading = connection.get_execution_options().get("reading", False)
    connection.exec_driver_sql("BEGIN" if reading else "BEGIN IMMEDIATE")
