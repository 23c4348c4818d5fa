"""Checkpoint of a split during generation: finished episodes on disk, so that `generate` can resume after a kill."""

import contextlib
import fcntl
import hashlib
import os
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cache
from importlib.util import find_spec
from pathlib import Path

from pydantic import TypeAdapter

from arramon_dataset.generation.batches import GeneratedEpisode
from arramon_server.episodes.split_files import parse_json, read_bytes
from arramon_server.errors import BadFile, Conflict, StorageError

FOLDER = "unfinished"
"""Subfolder of the data folder with the checkpoint of each unfinished split."""

SOURCES = ("arramon_server", "arramon_dataset", "arramon_lang", "arramon_agents", "arramon_client")
"""Packages whose code and data determine the generated episodes."""


@dataclass(frozen=True, slots=True)
class _Origin:
    """The first line of a checkpoint: a digest of everything but their ids that determines the episodes."""

    origin: str


_ORIGIN, _MADE = TypeAdapter(_Origin), TypeAdapter(GeneratedEpisode)


class GenerationCheckpoint:
    """The finished episodes of an unfinished split, in a file that is locked until `close`.

    Args:
        path: of the file; created if missing.
        origin: digest of everything but their ids that determines the episodes (see `generation_digest`). Episodes of
            another origin are discarded.

    Raises:
        Conflict: if another process is generating this split in this data folder.
        StorageError: if the file cannot be read or written.
    """

    def __init__(self, path: Path, origin: str) -> None:
        self._path, self._origin = path, origin
        try:
            path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
            self._file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND, 0o600)
        except OSError as error:
            raise StorageError(f"cannot write {path}: {error.strerror}") from error
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            os.close(self._file)
            raise Conflict(f"another process is generating the split {path.stem} in {path.parent.parent}") from error
        self.episodes, size = _read(path, origin)
        with self._errors():
            os.ftruncate(self._file, size)

    episodes: dict[str, GeneratedEpisode]
    """The episodes that the file held when it was opened, by id."""

    def add(self, made: Iterable[GeneratedEpisode]) -> None:
        """Append episodes. If the process is killed during the call, only some of them may be written.

        Raises:
            StorageError: if the file cannot be written.
        """
        lines = b"".join(_MADE.dump_json(one) + b"\n" for one in made)
        with self._errors():
            if not os.fstat(self._file).st_size:
                lines = _ORIGIN.dump_json(_Origin(self._origin)) + b"\n" + lines
            while lines:
                lines = lines[os.write(self._file, lines) :]

    def remove(self) -> None:
        """Delete the file; call this when the split is written."""
        with self._errors():
            self._path.unlink(missing_ok=True)
            with contextlib.suppress(OSError):  # Other splits may be unfinished.
                self._path.parent.rmdir()

    def close(self) -> None:
        """Unlock the file, and delete it if it is empty."""
        if not os.fstat(self._file).st_size:
            self.remove()
        os.close(self._file)

    @contextlib.contextmanager
    def _errors(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            raise StorageError(f"cannot write {self._path}: {error.strerror}") from error


def generation_digest(*parts: object) -> str:
    """Return a digest of the parts, and of the code and data of this release of the project."""
    return hashlib.sha256("\n".join((digest_of_sources(), *map(str, parts))).encode()).hexdigest()


@cache
def digest_of_sources() -> str:
    """Return a digest of the code and data of this release of the project, in hexadecimal."""
    digest = hashlib.sha256()
    for package in SOURCES:
        spec = find_spec(package)
        for folder in spec.submodule_search_locations or () if spec else ():
            for path in sorted(Path(folder).rglob("*")):
                if path.suffix in (".py", ".toml"):
                    content = read_bytes(path)
                    digest.update(f"{package}/{path.relative_to(folder).as_posix()} {len(content)}\n".encode())
                    digest.update(content)
    return digest.hexdigest()


def _read(path: Path, origin: str) -> tuple[dict[str, GeneratedEpisode], int]:
    """Return the episodes of a file and the length of its valid part, in bytes; 0 if it is of another origin."""
    *lines, _ = read_bytes(path).split(b"\n")
    try:
        if not lines or parse_json(_ORIGIN, lines[0], path, line=1).origin != origin:
            return {}, 0
    except BadFile:
        return {}, 0
    found, size = {}, len(lines[0]) + 1
    for number, line in enumerate(lines[1:], start=2):
        try:
            made = parse_json(_MADE, line, path, line=number)
        except BadFile:  # A power failure may leave arbitrary bytes at the end.
            break
        found[made.episode.episode_id] = made
        size += len(line) + 1
    return found, size
