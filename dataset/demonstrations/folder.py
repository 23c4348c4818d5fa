"""The folder of an export: its record, its finished parts, and atomic writes of files."""

import fcntl
import json
import os
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from arramon.strict_json import read_json
from arramon_server.errors import BadFile, BadInput, Conflict

RECORD = "demonstrations.json"
"""File name of the export's record: its settings and content."""

FORMAT, VERSION = "arramon-demonstrations", 1

WORK = ".export"
"""Subfolder with unfinished parts and records of finished ones; removed when the export is complete."""


class ExportFolder:
    """The output folder of an export.

    Args:
        path: of the folder.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._work = path / WORK

    def begin(self, settings: Mapping[str, Any]) -> bool:
        """Create the folder, or resume an export with the same settings; return whether it is complete.

        Raises:
            BadInput: if the folder contains other files.
            Conflict: if it contains an export with other settings.
            OSError: if it cannot be written.
        """
        if (self.path / RECORD).exists():
            record = read_record(self.path)
            for name, value in settings.items():
                if record["settings"].get(name) != value:
                    raise Conflict(
                        f"{self.path} contains an export whose {name} is {record['settings'].get(name)!r}, "
                        f"not {value!r}: expected the same settings to resume it, or another --output"
                    )
            if record["complete"]:
                shutil.rmtree(self._work, ignore_errors=True)
            return bool(record["complete"])
        if self.path.exists() and (not self.path.is_dir() or any(self._foreign())):
            raise BadInput(f"{self.path} contains other files than an export: expected a new or an empty folder")
        self._work.mkdir(parents=True, exist_ok=True)
        self.write_record({"complete": False, "settings": dict(settings)})
        return False

    def _foreign(self) -> Iterator[Path]:
        return (path for path in self.path.iterdir() if path.name != WORK)

    def write_record(self, content: Mapping[str, Any]) -> None:
        """Write the record of the export."""
        self.write_text(RECORD, as_json({"format": FORMAT, "version": VERSION, **content}))

    def write_text(self, name: str, text: str) -> None:
        """Write a text file of the export atomically."""
        new = self.scratch("text") / "new"
        new.write_text(text, encoding="utf-8")
        self.place(new, name)

    def place(self, new: Path, name: str) -> None:
        """Move a complete file to its place in the export, atomically."""
        with new.open("rb") as file:
            os.fsync(file.fileno())
        target = self.path / name
        target.parent.mkdir(parents=True, exist_ok=True)
        new.replace(target)

    def scratch(self, name: str) -> Path:
        """Return a new empty folder for unfinished files."""
        folder = self._work / f"new-{name}-{os.getpid()}"
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        return folder

    def finish_part(self, number: int, made: Path, content: Mapping[str, Any]) -> None:
        """Move the files of a part into place, then record that it is finished.

        Args:
            number: of the part.
            made: folder with the part's files, laid out as in the export.
            content: content of the part's record.
        """
        for file in sorted(path for path in made.rglob("*") if path.is_file()):
            self.place(file, file.relative_to(made).as_posix())
        shutil.rmtree(made)
        self.write_text(f"{WORK}/part-{number:05d}.json", as_json(content))

    def finished_parts(self) -> dict[int, dict[str, Any]]:
        """Return the records of the finished parts, by number."""
        found = sorted(self._work.glob("part-*.json"))
        return {int(path.stem.removeprefix("part-")): json.loads(path.read_text(encoding="utf-8")) for path in found}

    def end(self) -> None:
        """Remove the working files."""
        shutil.rmtree(self._work)

    @contextmanager
    def locked(self) -> Iterator[None]:
        """Lock this folder against other exports, and remove files that a killed export left.

        Raises:
            Conflict: if another export is writing to it.
        """
        self._work.mkdir(parents=True, exist_ok=True)
        with (self._work / "lock").open("w") as file:
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError as error:
                raise Conflict(
                    f"another export is writing to {self.path}; wait until it ends, or choose another --output"
                ) from error
            for left in self._work.glob("new-*"):
                shutil.rmtree(left)
            yield


def read_record(folder: Path) -> dict[str, Any]:
    """Return the record of an export.

    Raises:
        BadFile: if it is invalid.
    """
    path = folder / RECORD
    try:
        record = read_json(path.read_bytes())
    except (OSError, ValueError) as error:
        raise BadFile(path, f"cannot be read: {error}") from error
    if not isinstance(record, dict) or record.get("format") != FORMAT:
        raise BadFile(path, f"is not the record of an export: expected {FORMAT!r}", field="format")
    if record.get("version") != VERSION:
        raise BadFile(path, f"is {record.get('version')}; this release reads version {VERSION}", field="version")
    return record


def as_json(content: Mapping[str, Any]) -> str:
    """Return the text of a JSON file, indented; the same content gives the same text."""
    return json.dumps(content, ensure_ascii=False, indent=1) + "\n"
