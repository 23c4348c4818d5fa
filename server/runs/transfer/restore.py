"""Import of an export file into a database, in one transaction."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import sqlalchemy as sa
from sqlalchemy.engine import Connection

from arramon_server.errors import BadFile, Conflict, TakenOver, quoted
from arramon_server.runs.storage import tables
from arramon_server.runs.storage.database import Database
from arramon_server.runs.transfer.archive import EXPORTED_TABLES, columns_of, decode, encode, read_lines

_ROWS = 500
"""Number of rows to write at a time; a query must be able to name the keys of all of them."""

_BY_NAME = {table.name: table for table in EXPORTED_TABLES}


@dataclass(frozen=True, slots=True)
class ImportCounts:
    """Numbers of rows that an import added, and that existed already."""

    added: int
    present: int


def import_archive(database: Database, path: Path, *, merge: bool = False) -> ImportCounts:
    """Import all rows of a file, or none if an error occurs. Existing rows are kept, and must be equal.

    A run that was pruned since the export is restored, and no longer counted as pruned.

    Args:
        database: database to import into; no server should be using it.
        path: path of the file.
        merge: whether rows may be added to a database that has runs already.

    Raises:
        BadFile: if the file is incomplete or malformed.
        Conflict: if a row differs from that of the file with the same key; or, unless `merge`, if the database has
            runs and lacks rows of the file.
        StorageError: if the database cannot be written.
    """
    for _ in read_lines(path):  # checks the checksum before anything is written
        pass
    try:
        with database.write() as connection:
            return _Import(connection, path, merge).run()
    except TakenOver as error:
        raise BadFile(path, f"has rows that do not fit together: {error.__cause__}") from error


class _Import:
    """State of an import in one transaction."""

    def __init__(self, connection: Connection, path: Path, merge: bool) -> None:
        self._connection = connection
        self._path = path
        self._may_add = merge or not self._holds(tables.runs)
        self._added = self._present = 0

    def run(self) -> ImportCounts:
        table, columns, empty = EXPORTED_TABLES[0], list[str](), True
        batch: list[tuple[int, list[Any]]] = []
        for number, content in read_lines(self._path):
            if isinstance(content, dict):
                self._write(table, columns, batch, empty)
                batch = []
                table, columns = self._table(number, content)
                empty = not self._holds(table)
            else:
                batch.append((number, content))
                if len(batch) == _ROWS:
                    self._write(table, columns, batch, empty)
                    batch = []
        self._write(table, columns, batch, empty)
        self._restore_pruned()
        return ImportCounts(self._added, self._present)

    def _restore_pruned(self) -> None:
        """Stop counting runs as pruned that are in the database, as the import may have restored them."""
        pruned = tables.pruned_runs
        is_there = pruned.c.run_id.in_(sa.select(tables.runs.c.run_id))
        self._connection.execute(pruned.delete().where(is_there))

    def _holds(self, table: sa.Table) -> bool:
        return self._connection.execute(sa.select(sa.literal(1)).select_from(table).limit(1)).first() is not None

    def _table(self, number: int, content: dict[str, Any]) -> tuple[sa.Table, list[str]]:
        name, columns = content.get("table"), content.get("columns")
        if not isinstance(name, str) or name not in _BY_NAME or not isinstance(columns, list):
            raise BadFile(
                self._path, f"is {quoted(str(name))}, a table unknown to this server", line=number, field="table"
            )
        table = _BY_NAME[name]
        for column in columns:
            if column not in columns_of(table):
                problem = f"{name} has no column {quoted(str(column))} in this server"
                raise BadFile(self._path, problem, line=number, field="columns")
        missing = [key.name for key in table.primary_key.columns if key.name not in columns]
        if missing or len(set(columns)) < len(columns):
            problem = f"lacks {missing[0]!r}, which identifies a row" if missing else "names a column twice"
            raise BadFile(self._path, problem, line=number, field="columns")
        return table, columns

    def _write(self, table: sa.Table, columns: Sequence[str], batch: list[tuple[int, list[Any]]], empty: bool) -> None:
        """Write a batch of rows, given with their line numbers, except for existing ones."""
        rows = [self._decoded(table, columns, number, values) for number, values in batch]
        keys = [column.name for column in table.primary_key.columns]
        present = {} if empty or not rows else self._find(table, keys, rows)
        missing = []
        for row in rows:
            key = tuple(row[name] for name in keys)
            if key in present:
                _check_same(table, key, present[key], row)
            else:
                missing.append(row)
        self._present += len(rows) - len(missing)
        if not missing:
            return
        if not self._may_add:
            raise Conflict(
                f"the journal has runs already, but not {_named(table, [missing[0][name] for name in keys])} of the "
                "file; add missing rows with `--merge`"
            )
        self._connection.execute(table.insert(), missing)
        self._added += len(missing)

    def _decoded(self, table: sa.Table, columns: Sequence[str], number: int, values: list[Any]) -> dict[str, Any]:
        try:
            return decode(table, columns, values)
        except (ValueError, TypeError) as error:
            raise BadFile(self._path, f"is not a row of {table.name}: {error}", line=number) from error

    def _find(
        self, table: sa.Table, keys: Sequence[str], rows: Sequence[dict[str, Any]]
    ) -> dict[tuple[Any, ...], dict[str, Any]]:
        wanted = [tuple(row[name] for name in keys) for row in rows]
        condition = sa.tuple_(*(table.c[name] for name in keys)).in_(wanted)
        found = self._connection.execute(sa.select(table).where(condition))
        return {tuple(row[name] for name in keys): row for row in (row._asdict() for row in found)}


def _check_same(table: sa.Table, key: Sequence[Any], there: dict[str, Any], row: dict[str, Any]) -> None:
    columns = columns_of(table)
    brought = encode(table, {name: row.get(name) for name in columns})
    different = [
        name
        for name, one, other in zip(columns, encode(table, there), brought, strict=True)
        if name in row and one != other
    ]
    if different:
        raise Conflict(
            f"the journal has {_named(table, key)} already, with a different {' and '.join(different)} than the file"
        )


def _named(table: sa.Table, key: Sequence[Any]) -> str:
    return f"{table.name} {', '.join(part.hex() if isinstance(part, bytes) else str(part) for part in key)}"
