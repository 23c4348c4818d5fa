"""Reading, writing and validation of files: episodes (JSON Lines), sections and provenance (one JSON object each).

The first line of an episode file is the header; every further line is one `Episode` (see `episode`), field by field.
Version 1 has no `furniture`. `docs/reference/episodes.md` describes the format for authors of such files.
"""

import json
import zlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from pydantic import TypeAdapter, ValidationError
from pydantic_core import from_json

from arramon.strict_json import NotJsonError, read_json
from arramon_server.episodes.episode import Episode
from arramon_server.episodes.provenance import Provenance
from arramon_server.errors import BadFile
from arramon_server.sim.footprints import PROBE_HEIGHT
from arramon_server.sim.section import Section

EPISODE_FORMAT = "arramon-episodes"

PLAIN, FURNISHED = 1, 2
"""Versions of the format: without and with episodes' own furniture."""


MIN_DECOMPRESSED, MAX_RATIO = 64 << 20, 50
"""Maximum decompressed size: MIN_DECOMPRESSED bytes, or MAX_RATIO times the compressed size if that is more."""

_PIECE = 1 << 20
"""Bytes that are decompressed at a time."""

_LONGEST_HEADER = 1 << 20
"""Maximum bytes of a header, when only the header is read."""

_T = TypeVar("_T")


@dataclass(frozen=True, slots=True)
class EpisodeFileHeader:
    """The first line of an episode file.

    Attributes:
        format: always "arramon-episodes".
        version: version of the format, PLAIN or FURNISHED; others are rejected.
        split: name of the split, such as "val_seen".
        hidden: whether targets, goals and paths must never leave the server.
        source: origin of the episodes, as free text.
        training: whether the episodes are for training alone, and runs on them not ranked. Written where true.
    """

    format: str
    version: int
    split: str
    hidden: bool
    source: str
    training: bool = False


_HEADER = TypeAdapter(EpisodeFileHeader)
_EPISODE = TypeAdapter(Episode)
_SECTION = TypeAdapter(Section)
_PROVENANCE = TypeAdapter(Provenance)


def lowest_version(episodes: Iterable[Episode]) -> int:
    """Return the lowest format version that can hold the episodes, as older servers can read PLAIN files."""
    return PLAIN if all(episode.furniture.is_empty for episode in episodes) else FURNISHED


def write_episodes(path: Path, header: EpisodeFileHeader, episodes: Sequence[Episode]) -> None:
    """Write an episode file. The same episodes give the same bytes.

    Raises:
        ValueError: if the header's version cannot hold the episodes.
    """
    if header.version < lowest_version(episodes):
        raise ValueError(f"version {header.version} of the format holds no furniture; expected {FURNISHED}")
    left_out = {"furniture"} if header.version == PLAIN else None
    with path.open("wb") as file:
        file.write(_HEADER.dump_json(header, exclude_defaults=True) + b"\n")
        for episode in episodes:
            file.write(_EPISODE.dump_json(episode, exclude=left_out) + b"\n")


def read_episodes(path: Path) -> tuple[EpisodeFileHeader, list[Episode]]:
    """Read and validate an episode file of any version; one whose name ends in ".gz" is decompressed.

    Episodes of a file without furniture have their section's furniture unchanged.

    Raises:
        BadFile: if the content is wrong, naming the line and the field.
    """
    lines = read_bytes(path).split(b"\n")
    if lines[-1] != b"":
        raise BadFile(path, "the file is truncated: it does not end with a line break", line=len(lines))
    header = _check_header(path, parse_json(_HEADER, lines[0], path, line=1))
    episodes: dict[str, Episode] = {}
    for number, line in enumerate(lines[1:-1], start=2):
        episode = parse_json(_EPISODE, line, path, line=number)
        if header.version == PLAIN and not episode.furniture.is_empty:
            problem = f"is in a file of version {PLAIN}; expected version {FURNISHED} in the header"
            raise BadFile(path, problem, line=number, field="furniture")
        if episode.episode_id in episodes:
            raise BadFile(path, f"episode {episode.episode_id!r} occurs twice", line=number, field="episode_id")
        episodes[episode.episode_id] = episode
    return header, list(episodes.values())


def read_header(path: Path) -> EpisodeFileHeader:
    """Read only the header of an episode file, which is quick.

    Raises:
        BadFile: if it cannot be read or is wrong.
    """
    try:
        with path.open("rb") as file:
            line = file.readline(_LONGEST_HEADER)
    except OSError as error:
        raise BadFile(path, f"cannot be read: {error.strerror}") from error
    return _check_header(path, parse_json(_HEADER, line, path, line=1))


def write_section(path: Path, section: Section) -> None:
    """Write a section file, indented so that people can read and compare it."""
    path.write_bytes(_SECTION.dump_json(section, indent=1) + b"\n")


def read_section(path: Path) -> Section:
    """Read and validate a section file.

    Raises:
        BadFile: if the content is wrong, naming the field. Buildings must be higher than agents collide.
    """
    section = parse_json(_SECTION, read_bytes(path), path)
    for number, building in enumerate(section.buildings):
        if building.height < PROBE_HEIGHT:
            problem = f"is {building.height:g}; expected at least {PROBE_HEIGHT:g}, where agents collide"
            raise BadFile(path, problem, field=f"buildings[{number}].height")
    return section


def write_provenance(path: Path, provenance: Provenance) -> None:
    """Write a file of provenance, indented so that people can read it."""
    path.write_bytes(_PROVENANCE.dump_json(provenance, indent=1) + b"\n")


def read_provenance(path: Path) -> Provenance:
    """Read and validate a file of provenance.

    Raises:
        BadFile: if the content is wrong, naming the field.
    """
    return parse_json(_PROVENANCE, read_bytes(path), path)


def read_bytes(path: Path) -> bytes:
    """Return the content of a file.

    Raises:
        BadFile: if it cannot be read.
    """
    try:
        content = path.read_bytes()
    except OSError as error:
        raise BadFile(path, f"cannot be read: {error.strerror}") from error
    return _decompressed(path, content) if path.suffix == ".gz" else content


def max_decompressed_size(size: int) -> int:
    """Return the maximum decompressed size of a file of this size in bytes: more than any data file has."""
    return max(MIN_DECOMPRESSED, MAX_RATIO * size)


def _decompressed(path: Path, content: bytes) -> bytes:
    """Decompress a gzip file.

    Raises:
        BadFile: if it is malformed, or so much larger than any data file that it could fill the memory.
    """
    most, found = max_decompressed_size(len(content)), bytearray()
    while content:
        stream = zlib.decompressobj(wbits=zlib.MAX_WBITS | 16)
        while content and not stream.eof:
            try:
                found += stream.decompress(content, _PIECE)
            except zlib.error as error:
                raise BadFile(path, f"cannot be decompressed: {error}") from error
            if len(found) > most:
                raise BadFile(path, f"holds more than {most >> 20} MiB when it is decompressed, far more than its size")
            content = stream.unconsumed_tail
        if not stream.eof:
            raise BadFile(path, "cannot be decompressed: it is truncated")
        content = stream.unused_data.lstrip(b"\0")  # of several, one after another; zeros may fill up the last block
    return bytes(found)


def read_json_object(path: Path) -> dict[str, Any]:
    """Read a JSON object from a file.

    Raises:
        BadFile: if it cannot be read or is not a JSON object.
    """
    try:
        content = read_json(read_bytes(path))
    except NotJsonError as error:
        raise BadFile(path, str(error)) from error
    if not isinstance(content, dict):
        raise BadFile(path, "is not a JSON object")
    return content


def parse_json(adapter: TypeAdapter[_T], data: bytes, path: Path, *, line: int | None = None) -> _T:
    """Parse JSON and validate it against a type.

    Raises:
        BadFile: describing the first error.
    """
    try:
        return adapter.validate_python(from_json(data, allow_inf_nan=False))
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        raise BadFile(path, _explain(first), line=line, field=_dotted(first["loc"])) from error
    except ValueError as error:
        raise BadFile(path, f"is not JSON: {error}", line=line) from error


def _check_header(path: Path, header: EpisodeFileHeader) -> EpisodeFileHeader:
    if header.format != EPISODE_FORMAT:
        raise BadFile(path, f"is {header.format!r}, expected {EPISODE_FORMAT!r}", line=1, field="format")
    if header.version not in (PLAIN, FURNISHED):
        problem = f"is {header.version}; this release of the server reads versions {PLAIN} and {FURNISHED}"
        raise BadFile(path, problem, line=1, field="version")
    return header


def _explain(error: Any) -> str:
    message = str(error["msg"]).removeprefix("Value error, ")
    message = message[0].lower() + message[1:]
    given = json.dumps(error["input"], default=str, ensure_ascii=False)
    return message if error["type"] == "missing" or len(given) > 80 else f"{message}; got {given}"


def _dotted(location: tuple[int | str, ...]) -> str:
    """Return a location such as ("turns", 1, "path") as `turns[1].path`."""
    parts = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in location)
    return parts.removeprefix(".")
