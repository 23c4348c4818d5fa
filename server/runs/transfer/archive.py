"""File format of an export of the database, see `docs/how-to/export.md`.

It is JSON Lines in one Zstandard frame: a header; then for each table its name and columns, and its rows in the order
of their keys; finally the number of rows and the SHA-256 of all lines before. The same content gives the same bytes,
with either kind of database.
"""

import hashlib
import io
import json
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, BinaryIO

import sqlalchemy as sa
import zstandard

from arramon.strict_json import NotJsonError, read_json
from arramon_server.errors import BadFile
from arramon_server.runs.storage import tables
from arramon_server.runs.storage.database import utc

FORMAT, VERSION = "arramon-export", 1

EXPORTED_TABLES = (
    tables.participants,
    tables.earlier_names,
    tables.tokens,
    tables.quotas,
    tables.runs,
    tables.pruned_runs,
    tables.episodes,
    tables.images,
    tables.steps,
    tables.step_notes,
    tables.host_keys,
    tables.receipts,
    tables.entries,
    tables.epochs,
    tables.corrections,
    tables.rescored_runs,
    tables.superseded_receipts,
    *(table for table in tables.collections if table.name != "collection_sign_ins"),
)
"""Exported tables, each after those that it refers to. Workers, streams, the service clock and sign-ins belong to one
host."""

EXCLUDED_COLUMNS = frozenset(
    (
        *(tables.runs.c[name] for name in ("active_at", "away_until")),
        *(tables.episodes.c[name] for name in ("worker", "left", "sent", "sent_step")),
    )
)
"""Columns that are not exported, as they have no meaning on another host: no episode is open, its clock differs."""

_LEVEL, _BUFFER = 10, 1 << 20

_MAX_WINDOW = 1 << 27
"""Maximum window of the decompressor, in bytes; this level needs less."""

_LONGEST_LINE = 16 << 20
"""Maximum bytes of a line. The longest rows are receipts, of about 1 KB for each episode."""

_MIN_SIZE, _MAX_RATIO = 64 << 20, 1000
"""Maximum decompressed size: _MIN_SIZE bytes, or _MAX_RATIO times the file's size if that is more."""


def columns_of(table: sa.Table) -> list[str]:
    """Return the names of a table's exported columns, in order."""
    return [column.name for column in table.columns if column not in EXCLUDED_COLUMNS]


def encode(table: sa.Table, row: Mapping[str, Any]) -> list[Any]:
    """Return the values of a row as written to the file: times in ISO format in UTC, bytes in hexadecimal."""
    return [_plain(row[name]) for name in columns_of(table)]


def decode(table: sa.Table, columns: Sequence[str], values: Sequence[Any]) -> dict[str, Any]:
    """Return a row for insertion from the values that `encode` returned.

    Raises:
        ValueError, TypeError, KeyError: if the values do not fit the table.
    """
    return {name: _value(table.c[name], value) for name, value in zip(columns, values, strict=True)}


class ArchiveWriter:
    """Writes the header, the lines and the closing line of an export.

    Args:
        file: file to write to.

    Attributes:
        rows: number of rows written so far.
    """

    def __init__(self, file: BinaryIO) -> None:
        self._file = file
        self._digest = hashlib.sha256()
        self.rows = 0

    @contextmanager
    def frame(self) -> Iterator[None]:
        """Write the header and, at the end of the block unless it raises an error, the closing line.

        Raises:
            OSError: if the file cannot be written.
        """
        compressor = zstandard.ZstdCompressor(level=_LEVEL)
        with compressor.stream_writer(self._file, closefd=False) as self._stream:
            self.write({"format": FORMAT, "version": VERSION})
            yield
            self.write({"end": True, "rows": self.rows, "sha256": self._digest.hexdigest()})

    def write(self, content: object) -> None:
        """Write one line; lists count as rows."""
        line = json.dumps(content, ensure_ascii=False, separators=(",", ":")).encode() + b"\n"
        self.rows += isinstance(content, list)
        self._digest.update(line)
        self._stream.write(line)


def read_lines(path: Path) -> Iterator[tuple[int, Any]]:
    """Yield the lines of an export with their 1-based numbers, without the header and the closing line.

    Raises:
        BadFile: if the file is not an export. Truncation or a change is detected only at the end of the file.
    """
    digest, rows, number, ended = hashlib.sha256(), 0, 0, False
    table, width = "", 0
    for number, line in enumerate(_raw_lines(path), start=1):
        if ended:
            raise BadFile(path, "has data after its closing line", line=number)
        content = _parsed(path, number, line)
        if number == 1:
            _check_header(path, content)
        elif isinstance(content, dict) and "end" in content:
            if content != {"end": True, "rows": rows, "sha256": digest.hexdigest()}:
                raise BadFile(path, "has the wrong checksum: the file was changed", line=number)
            ended = True
        else:
            if isinstance(content, dict):
                table, width = str(content.get("table"))[:60], len(content.get("columns") or ())
            elif not isinstance(content, list) or len(content) != width or not table:
                expected = f"a row of {table} with {width} values" if table else "the name of a table"
                raise BadFile(path, f"is not {expected}", line=number)
            rows += isinstance(content, list)
            yield number, content
        digest.update(line)
    if not ended:
        raise BadFile(path, "is truncated: its closing line is missing", line=number + 1)


def _check_header(path: Path, content: Any) -> None:
    if not isinstance(content, dict) or content.get("format") != FORMAT:
        raise BadFile(path, f"is not an export: expected the format {FORMAT!r} in its first line", line=1)
    if content.get("version") != VERSION:
        raise BadFile(path, f"is {content.get('version')!r}, expected {VERSION}", line=1, field="version")


def _parsed(path: Path, number: int, line: bytes) -> Any:
    if not line.endswith(b"\n"):
        raise BadFile(path, "is truncated in the middle of a line", line=number)
    try:
        return read_json(line)
    except NotJsonError as error:
        raise BadFile(path, str(error), line=number) from error


def _raw_lines(path: Path) -> Iterator[bytes]:
    """Yield the lines as bytes, with their line breaks. The decompressed sizes of file and lines are limited."""
    size, number = 0, 0
    try:
        most = max(_MIN_SIZE, _MAX_RATIO * path.stat().st_size)
        decompressor = zstandard.ZstdDecompressor(max_window_size=_MAX_WINDOW)
        with path.open("rb") as file, decompressor.stream_reader(file) as stream:
            lines = io.BufferedReader(stream, _BUFFER)
            while line := lines.readline(_LONGEST_LINE + 1):
                size, number = size + len(line), number + 1
                if len(line) > _LONGEST_LINE:
                    raise BadFile(path, f"has more than {_LONGEST_LINE >> 20} MiB, more than any row", line=number)
                if size > most:
                    raise BadFile(path, f"expands to more than {_MAX_RATIO} times its size, as no export does")
                yield line
    except OSError as error:
        raise BadFile(path, f"cannot be read: {error.strerror}") from error
    except zstandard.ZstdError as error:
        raise BadFile(path, "is not a Zstandard file, or is damaged") from error


def _plain(value: Any) -> Any:
    if isinstance(value, datetime):
        return (utc(value) or value).astimezone(UTC).isoformat(timespec="microseconds")
    return value.hex() if isinstance(value, bytes | memoryview) else value


def _value(column: sa.Column[Any], value: Any) -> Any:
    if value is None:
        return None
    if isinstance(column.type, sa.DateTime):
        return datetime.fromisoformat(value)
    if isinstance(column.type, sa.LargeBinary):
        return bytes.fromhex(value)
    if not isinstance(column.type, sa.JSON):
        _check_type(column, value)
    return value


def _check_type(column: sa.Column[Any], value: Any) -> None:
    kind = column.type.python_type
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    if not (is_number if kind is float else type(value) is kind):
        raise ValueError(f"{column.name} is {str(value)[:60]!r}, expected {_KINDS[kind]}")
    if kind is int and abs(value) > _MOST:
        raise ValueError(f"{column.name} is {value}, expected at most {_MOST}")
    if kind is str:
        value.encode()  # half a character is no text


_KINDS = {str: "a text", int: "a whole number", float: "a number", bool: "true or false"}
_MOST = (1 << 31) - 1
"""Largest whole number that either database holds in these columns."""
