"""Writer of steps on a persistent connection, without SQLAlchemy's execution layer, for speed.

This saves 0.2 ms per step with SQLite and 0.8 ms with PostgreSQL.
"""

import sqlite3
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from functools import cache
from typing import Any

import psycopg
import sqlalchemy as sa
from sqlalchemy.dialects import sqlite
from sqlalchemy.engine import Connection, Dialect
from sqlalchemy.exc import DBAPIError

from arramon_server.runs.storage import postgres

Rows = Sequence[Mapping[str, Any]]


class StepWriter:
    """Connection that stays open between commits. Not thread-safe.

    Args:
        connect: opens a connection.
    """

    def __init__(self, connect: Callable[[], Connection]) -> None:
        self._connect = connect
        self._connection: Connection | None = None
        self._used = 0.0

    @contextmanager
    def use(self) -> Iterator[Connection]:
        """Yield the connection. An error in the block closes it, so that no transaction stays open."""
        with ExitStack() as broken:
            broken.callback(self.drop)
            yield self._live_connection()
            broken.pop_all()
        self._used = time.monotonic()

    def drop(self) -> None:
        """Close the connection; the next use opens a new one."""
        connection, self._connection = self._connection, None
        if connection is not None:
            connection.close()

    def insert(self, statement: sa.Insert, rows: Rows, more: Sequence[tuple[sa.Executable, Rows]] = ()) -> bool:
        """Insert rows into SQLite, all or none; return whether they were inserted.

        Args:
            statement: statement that inserts one row, or none.
            rows: parameters of the rows.
            more: statements, each with the parameters of its executions, that follow in the same transaction if all
                rows are inserted.

        Raises:
            DBAPIError: the subclass that SQLAlchemy would raise.
        """
        with self.use() as connection:
            text, values = _named(statement)
            with _driver_of(connection, text) as driver:
                driver.execute("BEGIN IMMEDIATE")
                done: bool = driver.executemany(text, [{**values, **row} for row in rows]).rowcount == len(rows)
                for following, parameters in more if done else ():
                    text, values = _named(following)
                    driver.executemany(text, [{**values, **row} for row in parameters])
                driver.execute("COMMIT" if done else "ROLLBACK")
                return done

    def insert_at_once(self, statement: sa.Executable, rows: Rows) -> bool:
        """Insert rows into PostgreSQL by one statement that takes one list per column, in a transaction of its own.

        Returns:
            Whether all rows were inserted.

        Raises:
            DBAPIError: the subclass that SQLAlchemy would raise.
        """
        with self.use() as connection:
            text = _text(statement, connection.dialect)
            with _driver_of(connection, text) as driver:
                columns = {name: [row[name] for row in rows] for name in rows[0]}
                done: bool = driver.execute(text, columns).rowcount == len(rows)
                return done

    def _live_connection(self) -> Connection:
        """Return the connection, or a new one if it is no longer alive."""
        kept = self._connection
        if kept is not None and not postgres.is_alive(kept, time.monotonic() - self._used):
            self.drop()
        if self._connection is None:
            self._connection = self._connect()
        return self._connection


@contextmanager
def _driver_of(connection: Connection, statement: str) -> Iterator[Any]:
    """Yield the connection of the driver, and convert its errors to those of SQLAlchemy."""
    driver = connection.connection.driver_connection
    try:
        yield driver
    except (sqlite3.Error, psycopg.Error) as error:
        dialect: Any = connection.dialect
        base: type[Exception] = sqlite3.Error if isinstance(error, sqlite3.Error) else psycopg.Error
        lost: bool = dialect.is_disconnect(error, connection.connection.dbapi_connection, None)
        if lost:
            connection.invalidate(error)
        raise DBAPIError.instance(statement, None, error, base, connection_invalidated=lost, dialect=dialect) from error


@cache
def _named(statement: Any) -> tuple[str, dict[str, Any]]:
    """Return the SQL text of a statement for SQLite, and the parameter values that the statement itself contains."""
    compiled = statement.compile(dialect=sqlite.dialect(paramstyle="named"))
    return str(compiled), dict(compiled.params)


@cache
def _text(statement: Any, dialect: Dialect) -> str:
    return str(statement.compile(dialect=dialect))
