"""The trace: every call of a run as a line of JSON, written before its answer is used, so that none is paid twice."""

import fcntl
import json
import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from arramon.strict_json import NotJsonError, read_json
from arramon_client.errors import StopRun

SUFFIX = ".vlm.jsonl"


class CallTrace:
    """The open trace of a run; one process at a time may hold it.

    Args:
        path: the file; it is created, for its owner alone as it holds instructions, or continued. An incomplete last
            line, which a killed process left, is removed.

    Attributes:
        path: the file.
        records: what the file held when it was opened, in order.
        fault: why a line could not be written; empty if all could. It stays until the trace is opened again.

    Raises:
        StopRun: if it cannot be opened, another process holds it, or a line is not JSON.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.fault = ""
        try:
            descriptor = os.open(path, os.O_RDWR | os.O_APPEND | os.O_CREAT | os.O_CLOEXEC, 0o600)
            self._file = os.fdopen(descriptor, "a+b", buffering=0)
        except OSError as error:
            raise StopRun(f"the trace {path} cannot be written: {error.strerror}") from error
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            self._file.close()
            raise StopRun(
                f"another process plays this run and writes {path}: wait for its end, or give this client a folder of "
                "its own with --agent-arg trace=DIR"
            ) from None
        except OSError as error:
            self._file.close()
            raise StopRun(
                f"the trace {path} cannot be locked: {error.strerror}. Keep it in a folder of this machine with "
                "--agent-arg trace=DIR"
            ) from None
        try:
            self.records = [*self._read()]
        except StopRun:
            self._file.close()
            raise

    def write(self, record: Mapping[str, Any]) -> bool:
        """Append a record, and return whether it was written; if not, nothing of it stays, and `fault` says why."""
        line = json.dumps(record, ensure_ascii=False, separators=(",", ":")).encode("utf-8", "replace") + b"\n"
        written = 0
        try:
            while written < len(line):
                written += os.write(self._file.fileno(), line[written:])
        except OSError as error:
            self.fault = f"the trace {self.path} cannot be written: {error.strerror}"
            if written:
                os.ftruncate(self._file.fileno(), os.fstat(self._file.fileno()).st_size - written)
            return False
        return True

    def check(self) -> None:
        """Check that every record was written.

        Raises:
            StopRun: if not: no further call may be paid.
        """
        if self.fault:
            raise StopRun(f"{self.fault}. No further call was made; make room and resume the run")

    def close(self) -> None:
        """Close the file, and let another process hold it."""
        self._file.close()

    def _read(self) -> Iterator[dict[str, Any]]:
        self._file.seek(0)
        whole = 0
        with os.fdopen(os.dup(self._file.fileno()), "rb") as lines:
            for number, line in enumerate(lines, 1):
                if not line.endswith(b"\n"):
                    break
                try:
                    record = read_json(line)
                except NotJsonError as error:
                    raise StopRun(f"the trace {self.path}, line {number} {error}: move the file away") from error
                if not isinstance(record, dict):
                    raise StopRun(f"the trace {self.path}, line {number} is not an object: move the file away")
                whole += len(line)
                yield record
        os.ftruncate(self._file.fileno(), whole)
