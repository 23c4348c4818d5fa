"""New SQLite databases with the tables that the migrations leave, which are run once in a process, not once a test."""

import time
from functools import cache

import sqlalchemy as sa
from sqlalchemy.engine import Connection

from arramon_server.runs.storage import database, migrations


def install() -> None:
    """From now on `database.Database` makes new SQLite databases in this process, and in its forks, by the record."""
    record()
    database.migrate = migrate  # type: ignore[attr-defined]


def uninstall() -> None:
    """From now on it runs the migrations again."""
    database.migrate = migrations.migrate  # type: ignore[attr-defined]


def migrate(connection: Connection, revision: str = "head") -> None:
    """`migrations.migrate`, but quick where the database is a new one of SQLite."""
    is_new = connection.dialect.name == "sqlite" and not sa.inspect(connection).get_table_names()
    if not is_new or revision != "head":
        migrations.migrate(connection, revision)
        return
    for statement in record():
        connection.exec_driver_sql(statement)
    now = time.time()
    connection.exec_driver_sql("INSERT INTO service_clock VALUES (1, ?, ?)", (now, now))
    connection.exec_driver_sql("INSERT INTO alembic_version VALUES (?)", (migrations.newest_revision(),))


@cache
def record() -> tuple[str, ...]:
    """The statements that make the tables and indexes as they are after all migrations."""
    engine = sa.create_engine("sqlite://")
    with engine.begin() as connection:
        migrations.migrate(connection)
        found = connection.exec_driver_sql("SELECT sql FROM sqlite_master WHERE sql IS NOT NULL ORDER BY rowid").all()
    engine.dispose()
    return tuple(statement for (statement,) in found)


def open_unrecorded(arguments: list[str]) -> int:
    """Open the database with this URL as a process that does not know the record; for `forked.Forked`."""
    uninstall()
    database.Database(*arguments).close()
    return 0
