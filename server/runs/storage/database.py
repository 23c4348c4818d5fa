"""The journal's database: opens and migrates it, and converts its errors to errors of the server."""

import os
import sqlite3
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager, suppress
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

from arramon_server.errors import BadInput, StorageError, TakenOver
from arramon_server.runs.storage import postgres
from arramon_server.runs.storage.migrations import check_revision, migrate, newest_revision, revision_of
from arramon_server.runs.storage.step_writer import Rows, StepWriter

PAUSE_FACTOR, MAX_PAUSE_SECONDS, QUICK_FAILURE_SECONDS = 4.0, 10.0, 0.5
"""A failure slower than QUICK_FAILURE_SECONDS pauses use of the database for PAUSE_FACTOR times its duration, at most
MAX_PAUSE_SECONDS: the event loop must serve the streams meanwhile."""


class Database:
    """SQLite or PostgreSQL database, selected by URL. Thread-safe, except for `commit`.

    Args:
        url: `sqlite:////var/lib/arramon/journal.db` or `postgresql://user:password@host/name`.
        fsync: whether a commit waits for the disk (PostgreSQL: as it is configured). Otherwise commits survive the end
            of any process, but the last ones may be lost in a power failure; the client plays those steps again.
        clock: returns this machine's time, in seconds since 1970. PostgreSQL uses its own, which all hosts share.
        patient: whether statements may take minutes, as for an export or import; a server uses short timeouts.
        read_only: whether to open it for reading only, with long timeouts; it must be up to date.

    Raises:
        BadInput: if the URL is neither of SQLite nor of PostgreSQL.
        StorageError: if the database cannot be opened or written, or has tables of another version.
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
        self._paused_until, self._reason = 0.0, ""
        if read_only:
            if self._is_sqlite and not Path(self._file).is_file():
                raise StorageError(f"there is no journal {self._file} yet; `arramon-server serve` creates it")
            self._connect(_engine(_read_only(parsed), fsync=fsync, patient=True, read_only=True))
            self._check_revision()
            return
        if self._is_sqlite and parsed.database:
            _check_folder(Path(parsed.database))
            _claim_file(Path(parsed.database))
        migrating = _engine(parsed, fsync=fsync, migrating=True)
        try:
            with self._errors(), migrating.begin() as connection:
                if not self._is_sqlite:
                    postgres.lock_migrations(connection)
                migrate(connection)
        except CommandError as error:
            raise StorageError(
                f"the journal was written by another version of this server: {error}; "
                f"this one supports tables up to version {newest_revision()}"
            ) from error
        finally:
            migrating.dispose()
        self._connect(_engine(parsed, fsync=fsync, patient=patient))

    def _connect(self, engine: Engine) -> None:
        self._engine = engine
        reading: dict[str, Any] = {"reading": True} if self._is_sqlite else {"isolation_level": "AUTOCOMMIT"}
        self._read_engine = self._engine.execution_options(**reading)
        # SQLite: transactions are begun explicitly. PostgreSQL: each statement is a transaction of its own.
        self._step_writer = StepWriter(engine.connect if self._is_sqlite else self._read_engine.connect)

    @property
    def now(self) -> sa.ColumnElement[float]:
        """SQL expression of the current time in seconds since 1970, by one clock for all processes on the database."""
        if self._is_sqlite:
            return sa.literal(self._clock(), sa.Float)
        return sa.cast(sa.extract("epoch", sa.func.clock_timestamp()), sa.Float)

    @property
    def is_file(self) -> bool:
        """Whether the database is a file on this machine, which means SQLite."""
        return self._is_sqlite

    def copy(self, path: Path) -> None:
        """Copy a snapshot of an SQLite database, even while it is written to, and check the copy.

        Args:
            path: path of the copy, which is readable by its owner only.

        Raises:
            StorageError: if the database cannot be read or is damaged, or the copy cannot be written.
        """
        _claim_file(path)
        with self._errors(), self._engine.connect() as connection, closing(sqlite3.connect(path)) as copy:
            original = connection.connection.driver_connection
            assert isinstance(original, sqlite3.Connection)
            try:
                original.backup(copy)
                (found,) = copy.execute("PRAGMA quick_check(1)").fetchone()
            except sqlite3.Error as error:
                raise StorageError(f"cannot copy the journal to {path}: {error}") from error
        if found != "ok":
            raise StorageError(f"the journal {self._file} is damaged: {found}")

    def vacuum(self) -> None:
        """Free the space of deleted rows: SQLite rewrites its file, which takes as much free disk space again.

        Raises:
            StorageError: if the database cannot be written.
        """
        with self._errors(), self._engine.connect() as connection:
            if not self._is_sqlite:
                connection.execution_options(isolation_level="AUTOCOMMIT").exec_driver_sql("VACUUM (ANALYZE)")
                return
            file = connection.connection.driver_connection
            assert isinstance(file, sqlite3.Connection)
            try:
                file.execute("VACUUM")
                file.execute("PRAGMA wal_checkpoint(TRUNCATE)")
            except sqlite3.Error as error:
                raise StorageError(f"cannot compact the journal {self._file}: {error}") from error

    def close(self) -> None:
        """Close all connections."""
        self._step_writer.drop()
        self._engine.dispose()

    def read(self, query: sa.Select[Any]) -> Sequence[Row[Any]]:
        """Return the rows of a query.

        Raises:
            BadInput: if the query has a value that the database cannot represent.
            StorageError: if the database cannot be read.
        """
        with self._errors(), self._read_engine.connect() as connection:
            return connection.execute(query).all()

    @contextmanager
    def snapshot(self) -> Iterator[Connection]:
        """Yield a connection that reads a consistent snapshot, even while others write.

        Raises:
            StorageError: if the database cannot be read.
        """
        isolated: dict[str, Any] = {"isolation_level": "REPEATABLE READ", "postgresql_readonly": True}
        options: dict[str, Any] = {"reading": True} if self._is_sqlite else isolated
        with self._errors(), self._engine.connect() as connection:
            yield connection.execution_options(**options)

    @contextmanager
    def write(self) -> Iterator[Connection]:
        """Yield a connection in a transaction: committed at the end of the block, rolled back after an error.

        Raises:
            TakenOver: if a row exists already.
            BadInput: if a value is written that the database cannot represent.
            StorageError: if the database cannot be written.
        """
        with self._errors(), self._engine.begin() as connection:
            yield connection

    @contextmanager
    def erase(self) -> Iterator[Connection]:
        """Do the same as `write`, but overwrite on the disk what is deleted. With PostgreSQL, `vacuum` does that later.

        With SQLite this includes the write-ahead log, unless somebody reads meanwhile; then later commits do it.

        Raises:
            TakenOver, BadInput, StorageError: as for `write`.
        """
        if not self._is_sqlite:
            with self.write() as connection:
                yield connection
            return
        with self._errors(), self._engine.connect() as connection:
            file = connection.connection.driver_connection
            assert isinstance(file, sqlite3.Connection)
            file.execute("PRAGMA secure_delete=ON")
            try:
                with connection.begin():
                    yield connection
                file.execute("PRAGMA wal_checkpoint(TRUNCATE)")
            finally:
                file.execute("PRAGMA secure_delete=OFF")

    @contextmanager
    def commit(self) -> Iterator[Connection]:
        """Do the same as `write`, but on a persistent connection with SQLite, as commits are frequent."""
        if not self._is_sqlite:  # the pool checks whether a connection is alive
            with self.write() as connection:
                yield connection
            return
        with self._errors(), self._step_writer.use() as connection, connection.begin():
            yield connection

    def commit_rows(
        self,
        statement: sa.Insert,
        rows: Rows,
        *,
        at_once: sa.Executable,
        more: Sequence[tuple[sa.Executable, Rows]] = (),
    ) -> bool:
        """Insert rows, all or none, in a transaction of their own; return whether they were inserted.

        Args:
            statement: statement that inserts one row, or none; used with SQLite.
            rows: parameters of the rows.
            at_once: statement that inserts all rows, given as one list per column, or none; used with PostgreSQL,
                where each round trip takes time.
            more: statements that follow in the same transaction, each with the parameters of its executions; used with
                SQLite only.

        Raises:
            TakenOver: if a row exists already.
            StorageError: if the database cannot be written.
        """
        with self._errors():
            return (
                self._step_writer.insert(statement, rows, more)
                if self._is_sqlite
                else self._step_writer.insert_at_once(at_once, rows)
            )

    def _check_revision(self) -> None:
        with self.snapshot() as connection:
            found = revision_of(connection)
        check_revision(found)
        if found != newest_revision():
            raise StorageError(
                f"the journal has tables of version {found or 'none'}, expected {newest_revision()}; "
                "`arramon-server serve` migrates an older one"
            )

    @contextmanager
    def _errors(self) -> Iterator[None]:
        started = time.monotonic()
        if started < self._paused_until:
            raise StorageError(self._reason)
        try:
            yield
        except IntegrityError as error:
            raise TakenOver(f"the journal contains this already: {error.orig}") from error
        except DataError as error:
            raise BadInput(f"the journal cannot store this: {error.orig}") from error
        except (DBAPIError, PoolTimeoutError) as error:
            reason = error.orig if isinstance(error, DBAPIError) else error
            self._reason = f"the journal cannot be used: {reason}"
            if "unable to open" in str(reason):
                self._reason += f" {self._file}"
            gone = isinstance(error, OperationalError) and (error.connection_invalidated or error.statement is None)
            if gone and (failed := time.monotonic()) > started + QUICK_FAILURE_SECONDS:
                self._paused_until = failed + min(PAUSE_FACTOR * (failed - started), MAX_PAUSE_SECONDS)
            raise StorageError(self._reason) from error


def _check_folder(path: Path) -> None:
    if not path.parent.is_dir():
        raise StorageError(f"the journal {path} cannot be created: there is no folder {path.parent}")


def _claim_file(path: Path) -> None:
    """Create the file of a new database, readable by its owner only, as it will hold data that is not public."""
    with suppress(OSError):  # SQLite reports what is wrong with the path
        os.close(os.open(path, os.O_CREAT, 0o600))


def utc(time: datetime | None) -> datetime | None:
    """Return a time read from the database in UTC: SQLite drops the time zone."""
    return time.replace(tzinfo=UTC) if time is not None and time.tzinfo is None else time


def _parsed(url: str) -> URL:
    expected = "expected sqlite:///PATH or postgresql://USER:PASSWORD@HOST/NAME"
    try:
        parsed = make_url(url)
    except (ArgumentError, ValueError):  # the message could contain a password
        raise BadInput(f"the journal's URL is malformed; {expected}") from None
    kind = parsed.drivername.partition("+")[0]
    if kind == "sqlite":
        return parsed
    if kind in ("postgresql", "postgres"):
        if "@" in f"{parsed.host or ''}{parsed.database or ''}":  # the rest of a password would pass for the host
            raise BadInput(
                "the journal's URL has more than one @: write one that belongs to the user or the password as %40; "
                f"{expected}"
            )
        return parsed.set(drivername="postgresql+psycopg")
    raise BadInput(f"the journal's database {kind!r} is not supported; {expected}")


def _read_only(url: URL) -> URL:
    """Return the URL with which SQLite opens an existing file for reading only; others unchanged."""
    if url.get_backend_name() != "sqlite":
        return url
    return url.set(database=f"file:{quote(url.database or '')}").update_query_dict({"mode": "ro", "uri": "true"})


def _engine(
    url: URL, *, fsync: bool, migrating: bool = False, patient: bool = False, read_only: bool = False
) -> Engine:
    if url.get_backend_name() != "sqlite":
        return postgres.postgres_engine(url, fsync=fsync, migrating=migrating or patient)
    engine = sa.create_engine(url)
    # A migration may recreate a table; rows that refer to it must not be deleted with the old one.
    pragmas = {"busy_timeout": "10000", "journal_mode": "WAL", "synchronous": "FULL" if fsync else "NORMAL"}
    pragmas["foreign_keys"] = "OFF" if migrating else "ON"
    if read_only:
        pragmas = {"busy_timeout": "10000"}
    event.listen(engine, "connect", partial(_prepare_sqlite, pragmas))
    event.listen(engine, "begin", _begin_sqlite)
    return engine


def _prepare_sqlite(pragmas: dict[str, str], connection: Any, _record: object) -> None:
    connection.isolation_level = None  # otherwise the driver begins and commits transactions itself
    for name, value in pragmas.items():
        connection.execute(f"PRAGMA {name}={value}")


def _begin_sqlite(connection: Connection) -> None:
    # A writer takes its lock at the start: of two that read first and then write, one would fail instead of waiting.
    reading = connection.get_execution_options().get("reading", False)
    connection.exec_driver_sql("BEGIN" if reading else "BEGIN IMMEDIATE")
