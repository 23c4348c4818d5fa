"""From the database to a file that carries the whole leaderboard to another host."""

import os
import tempfile
from pathlib import Path
from typing import Any

import sqlalchemy as sa
from sqlalchemy.engine import Connection

from server.errors import StorageError
from server.runs.database import Database
from server.runs.transfer import CARRIED, Writer, columns_of, encode

_ROWS = 1000
"""Read at a time."""


def export(database: Database, path: Path) -> int:
    """Writes everything, as it stands at one moment, whole or not at all; returns the number of rows.

    Args:
        database: may be a running server's.
        path: of the file, readable by its owner alone; one that is there is replaced.

    Raises:
        StorageError: if the database cannot be read, or the file not be written.
    """
    try:
        # Of mode 600: there are the hashes of tokens in it.
        descriptor, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}-")
    except OSError as error:
        raise StorageError(f"cannot write {path}: {error.strerror}") from error
    part = Path(name)
    try:
        with os.fdopen(descriptor, "wb") as file, database.snapshot() as connection:
            writer = Writer(file)
            with writer.opened():
                for table in CARRIED:
                    _write_table(writer, connection, table)
            file.flush()
            os.fsync(file.fileno())
        part.replace(path)
    except OSError as error:
        raise StorageError(f"cannot write {path}: {error.strerror}") from error
    finally:
        part.unlink(missing_ok=True)
    return writer.rows


def _write_table(writer: Writer, connection: Connection, table: sa.Table) -> None:
    columns = columns_of(table)
    writer.write({"table": table.name, "columns": columns})
    query = sa.select(*(table.c[name] for name in columns)).order_by(
        *(_by_bytes(connection, key) for key in table.primary_key.columns)
    )
    for row in connection.execute(query, execution_options={"yield_per": _ROWS}):
        writer.write(encode(table, row._asdict()))


def _by_bytes(connection: Connection, column: sa.Column[Any]) -> sa.ColumnElement[Any]:
    """What to order by, so that the order is the same in every database: PostgreSQL goes by the host's language."""
    if connection.dialect.name == "postgresql" and isinstance(column.type, sa.String):
        return sa.collate(column, "C")
    return column
