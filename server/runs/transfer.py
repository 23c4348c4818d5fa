"""A whole leaderboard as one file, to be carried to another host. `docs/export.md` describes it.

It is JSON Lines in one Zstandard frame: a header; then for each table its name and columns, and its rows in the order
of their keys; at last the number of rows and the SHA-256 of all lines before. The same content gives the same bytes,
whichever database it comes from.
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

from server.errors import BadFile
from server.runs import tables
from server.runs.database import utc

FORMAT, VERSION = "arramon-export", 1

CARRIED = (
    tables.participants,
    tables.tokens,
    tables.quotas,
    tables.runs,
    tables.episodes,
    tables.images,
    tables.steps,
    tables.host_keys,
    tables.receipts,
    tables.entries,
)
"""What goes along, each table behind those that it refers to. Workers and streams are of one host's processes."""

LEFT_BEHIND = frozenset((tables.episodes.c.worker,))
"""Columns that mean nothing at another host, where nobody has an episode open."""

_LEVEL, _BUFFER = 10, 1 << 20


def columns_of(table: sa.Table) -> list[str]:
    """The columns of a table that are carried, in order."""
    return [column.name for column in table.columns if column not in LEFT_BEHIND]


def encode(table: sa.Table, row: Mapping[str, Any]) -> list[Any]:
    """A row as it stands in the file: times in UTC, bytes in hexadecimal."""
    return [_plain(row[name]) for name in columns_of(table)]


def decode(table: sa.Table, columns: Sequence[str], values: Sequence[Any]) -> dict[str, Any]:
    """A row as it is inserted, from what `encode` gave.

    Raises:
        ValueError, TypeError, KeyError: if it is none of this table's.
    """
    return {name: _value(table.c[name], value) for name, value in zip(columns, values, strict=True)}


class Writer:
    """Writes lines, and what closes them.

    Args:
        file: to write to.

    Attributes:
        rows: written so far.
    """

    def __init__(self, file: BinaryIO) -> None:
        self._file = file
        self._digest = hashlib.sha256()
        self.rows = 0

    @contextmanager
    def opened(self) -> Iterator[None]:
        """Takes lines as long as the block lasts; the closing line comes where no error has left it.

        Raises:
            OSError: if the file cannot be written.
        """
        compressor = zstandard.ZstdCompressor(level=_LEVEL)
        with compressor.stream_writer(self._file, closefd=False) as self._stream:
            self.write({"format": FORMAT, "version": VERSION})
            yield
            self.write({"end": True, "rows": self.rows, "sha256": self._digest.hexdigest()})

    def write(self, content: object) -> None:
        """One line; a list is a row."""
        line = json.dumps(content, ensure_ascii=False, separators=(",", ":")).encode() + b"\n"
        self.rows += isinstance(content, list)
        self._digest.update(line)
        self._stream.write(line)


def read_lines(path: Path) -> Iterator[tuple[int, Any]]:
    """The lines of a file with their 1-based numbers, without header and end.

    Raises:
        BadFile: if it is not such a file. That it is cut or was changed shows at its end.
    """
    digest, rows, number, ended = hashlib.sha256(), 0, 0, False
    for number, line in enumerate(_raw_lines(path), start=1):
        if ended:
            raise BadFile(path, "goes on behind its end", line=number)
        content = _parsed(path, number, line)
        if number == 1:
            _check_header(path, content)
        elif isinstance(content, dict) and "end" in content:
            if content != {"end": True, "rows": rows, "sha256": digest.hexdigest()}:
                raise BadFile(path, "its checksum is wrong: the file was changed", line=number)
            ended = True
        else:
            rows += isinstance(content, list)
            yield number, content
        digest.update(line)
    if not ended:
        raise BadFile(path, "is cut: its end is missing", line=number + 1)


def _check_header(path: Path, content: Any) -> None:
    if not isinstance(content, dict) or content.get("format") != FORMAT:
        raise BadFile(path, f"is not an export: its first line has no format {FORMAT!r}", line=1)
    if content.get("version") != VERSION:
        raise BadFile(path, f"is {content.get('version')!r}, expected {VERSION}", line=1, field="version")


def _parsed(path: Path, number: int, line: bytes) -> Any:
    if not line.endswith(b"\n"):
        raise BadFile(path, "is cut in the middle of a line", line=number)
    try:
        return json.loads(line)
    except ValueError as error:
        raise BadFile(path, "is not JSON", line=number) from error


def _raw_lines(path: Path) -> Iterator[bytes]:
    """The lines as bytes, their ends included."""
    try:
        with path.open("rb") as file, zstandard.ZstdDecompressor().stream_reader(file) as stream:
            yield from io.BufferedReader(stream, _BUFFER)
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
    return bytes.fromhex(value) if isinstance(column.type, sa.LargeBinary) else value
