"""Export of the database to a file."""

import os
import tempfile
from pathlib import Path
from typing import Any

import sqlalchemy as sa
from sqlalchemy.engine import Connection

from arramon_server.errors import StorageError
from arramon_server.runs.storage.database import Database
from arramon_server.runs.transfer.archive import EXPORTED_TABLES, ArchiveWriter, columns_of, encode

_ROWS = 1000
"""Number of rows to read at a time."""


def export(database: Database, path: Path) -> int:
    """Export a snapshot of a database; return the number of rows. The file is written completely or not at all.

    Args:
        database: database to export, also that of a running server.
        path: path of the file, which is readable by its owner only; an existing file is replaced.

    Raises:
        StorageError: if the database cannot be read, or the file cannot be written.
    """
    try:
        # Created with mode 600, as it contains the hashes of tokens.
        descriptor, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}-")
    except OSError as error:
        raise StorageError(f"cannot write {path}: {error.strerror}") from error
    part = Path(name)
    try:
        with os.fdopen(descriptor, "wb") as file, database.snapshot() as connection:
            writer = ArchiveWriter(file)
            with writer.frame():
                for table in EXPORTED_TABLES:
                    _write_table(writer, connection, table)
            file.flush()
            os.fsync(file.fileno())
        part.replace(path)
    except OSError as error:
        raise StorageError(f"cannot write {path}: {error.strerror}") from error
    finally:
        part.unlink(missing_ok=True)
    return writer.rows


def _write_table(writer: ArchiveWriter, connection: Connection, table: sa.Table) -> None:
    columns = columns_of(table)
    writer.write({"table": table.name, "columns": columns})
    query = sa.select(*(table.c[name] for name in columns)).order_by(
        *(_by_bytes(connection, key) for key in table.primary_key.columns)
    )
    for row in connection.execute(query, execution_options={"yield_per": _ROWS}):
        writer.write(encode(table, row._asdict()))


def _by_bytes(connection: Connection, column: sa.Column[Any]) -> sa.ColumnElement[Any]:
    """Return a sort key with the same order in every database: PostgreSQL would use the host's locale."""
    if connection.dialect.name == "postgresql" and isinstance(column.type, sa.String):
        return sa.collate(column, "C")
    return column
