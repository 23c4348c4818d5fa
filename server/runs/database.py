"""The database behind the journal: opens it, brings it up to date, and turns its errors into the server's."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import Any
from urllib.parse import quote

import sqlalchemy as sa
from alembic import command
from alembic.config import Config
from alembic.runtime.migration import MigrationContext
from alembic.script import ScriptDirectory
from sqlalchemy import event
from sqlalchemy.engine import Connection, Engine, Row
from sqlalchemy.exc import DBAPIError, IntegrityError

from server.errors import StorageError, TakenOver


class Database:
    """SQLite, or another database by URL. Safe to use from several threads, but for `commit`, which belongs to one.

    Args:
        url: such as `sqlite:////var/lib/arramon/journal.db`.
        fsync: whether SQLite waits for the disk with every commit. Without, a commit outlives the end of any process,
            but the last ones may be gone after a loss of power; the client then plays those steps again.
        read_only: whether it is only looked at: it must be there, and up to date, and stays as it is.

    Raises:
        StorageError: if the database cannot be opened or written.
    """

    def __init__(self, url: str, *, fsync: bool = True, read_only: bool = False) -> None:
        self._engine = _engine(url, fsync, read_only)
        self._committer: Connection | None = None
        config = Config()
        config.set_main_option("script_location", str(Path(__file__).parent / "migrations"))
        if read_only:
            self._check_revision(ScriptDirectory.from_config(config).get_current_head())
            return
        with self.write() as connection:
            config.attributes["connection"] = connection
            command.upgrade(config, "head")

    def close(self) -> None:
        """Lets the database go."""
        self._drop_committer()
        self._engine.dispose()

    def read(self, query: sa.Select[Any]) -> Sequence[Row[Any]]:
        """The rows that a query finds.

        Raises:
            StorageError: if the database cannot be read.
        """
        with _storage_errors(), self._engine.connect() as connection:
            return connection.execution_options(reading=True).execute(query).all()

    @contextmanager
    def snapshot(self) -> Iterator[Connection]:
        """A connection to read through that shows everything as it stood at one moment, whatever is written meanwhile.

        Raises:
            StorageError: if the database cannot be read.
        """
        postgresql = self._engine.dialect.name == "postgresql"
        options = {"isolation_level": "REPEATABLE READ", "postgresql_readonly": True} if postgresql else {}
        with _storage_errors(), self._engine.connect() as connection:
            yield connection.execution_options(reading=True, **options)

    @contextmanager
    def write(self) -> Iterator[Connection]:
        """A connection to write through: all of it, or nothing where an error leaves the block.

        Raises:
            TakenOver: if a row is there already.
            StorageError: if the database cannot be written.
        """
        with _storage_errors(), self._engine.begin() as connection:
            yield connection

    @contextmanager
    def commit(self) -> Iterator[Connection]:
        """As `write`, on a connection that is kept: this is done with every step."""
        with _storage_errors():
            if self._committer is None:
                self._committer = self._engine.connect()
            try:
                with self._committer.begin():
                    yield self._committer
            except DBAPIError:
                self._drop_committer()
                raise

    def _check_revision(self, expected: str | None) -> None:
        with self.snapshot() as connection:
            found = MigrationContext.configure(connection).get_current_revision()
        if found != expected:
            raise StorageError(
                f"the journal has the tables of version {found or 'none'}, expected {expected}; "
                "`arramon-server serve` brings an older one up to date"
            )

    def _drop_committer(self) -> None:
        committer, self._committer = self._committer, None
        if committer is not None:
            committer.close()


def utc(time: datetime | None) -> datetime | None:
    """A time as it was written: SQLite drops its zone."""
    return time.replace(tzinfo=UTC) if time is not None and time.tzinfo is None else time


def _engine(url: str, fsync: bool, read_only: bool) -> Engine:
    parsed = sa.make_url(url)
    if read_only and parsed.get_backend_name() == "sqlite":
        parsed = parsed.set(database=f"file:{quote(parsed.database or '')}").update_query_dict(
            {"mode": "ro", "uri": "1"}
        )
    engine = sa.create_engine(parsed)
    if engine.dialect.name == "sqlite":
        writing = ("journal_mode=WAL", f"synchronous={'FULL' if fsync else 'NORMAL'}", "foreign_keys=ON")
        pragmas = ("busy_timeout=10000", *(() if read_only else writing))
        event.listen(engine, "connect", partial(_prepare_sqlite, pragmas))
        event.listen(engine, "begin", _begin_sqlite)
    return engine


def _prepare_sqlite(pragmas: Sequence[str], connection: Any, _record: object) -> None:
    connection.isolation_level = None  # or the driver commits and begins behind SQLAlchemy's back
    for pragma in pragmas:
        connection.execute(f"PRAGMA {pragma}")


def _begin_sqlite(connection: Connection) -> None:
    # A writer takes its lock at once: two that first read and then write would be turned away instead of waiting.
    reading = connection.get_execution_options().get("reading", False)
    connection.exec_driver_sql("BEGIN" if reading else "BEGIN IMMEDIATE")


@contextmanager
def _storage_errors() -> Iterator[None]:
    try:
        yield
    except IntegrityError as error:
        raise TakenOver(f"the journal holds this already: {error.orig}") from error
    except DBAPIError as error:
        raise StorageError(f"the journal cannot be used: {error.orig}") from error
