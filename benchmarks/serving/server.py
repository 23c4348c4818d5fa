"""The server under measurement, started as users start it, with its CPU time and memory."""

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from arramon.v1 import types_pb2

SENSORS = ("rgb", "depth")


@dataclass(frozen=True)
class ServerSetting:
    """Settings of a measured server and of the play on it.

    Attributes:
        name: name of the table row.
        parallel: number of open episodes.
        size: side length of the images, in pixels.
        encoding: of the images.
        tcp: whether clients connect over TCP; otherwise through a Unix socket.
        workers: number of server processes.
        sensors: sensors of the agent.
        fsync: whether commits wait for the disk.
        postgres: whether the journal is in PostgreSQL; otherwise in a file of SQLite.
        steps: step limit of a phase; None for the server's own.
        program: interpreter arguments that start the server.
        more: further arguments of `serve`.
    """

    name: str
    parallel: int = 16
    size: int = 224
    encoding: types_pb2.Encoding.ValueType = types_pb2.ENCODING_SHARED
    tcp: bool = False
    workers: int = 1
    sensors: tuple[str, ...] = SENSORS
    fsync: bool = False
    postgres: bool = False
    steps: int | None = None
    program: tuple[str, ...] = ("-m", "arramon_server")
    more: tuple[str, ...] = ()


class MeasuredServer:
    """A server process with its own journal.

    Args:
        data: data folder.
        setting: settings.
        folder: for its socket and its journal.
        journal: URL of another journal.
        environment: variables besides those of this process.

    Attributes:
        address: address on which it listens.
        pages: URL of its pages; empty if it serves none.
        ready: seconds from its start until it listened.
    """

    def __init__(
        self,
        data: Path,
        setting: ServerSetting,
        folder: Path,
        journal: str = "",
        environment: Mapping[str, str] | None = None,
    ) -> None:
        self.address = "127.0.0.1:0" if setting.tcp else f"unix:{folder}/socket"
        self._command = [sys.executable, *setting.program, "serve", "--data", str(data)]
        self._command += ["--journal", journal or f"sqlite:///{folder}/journal.db", "--workers", str(setting.workers)]
        self._command += ["--fsync" if setting.fsync else "--no-fsync"]
        self._command += ["--steps", str(setting.steps)] if setting.steps else []
        self._command += setting.more
        self.pages = ""
        self._environment = {**os.environ, **(environment or {})}
        self.start()

    def start(self) -> None:
        """Start or restart the server on the same address, and wait until it listens.

        Raises:
            SystemExit: if it exits before that; its message is on standard error.
        """
        command, started = [*self._command, "--listen", self.address], time.perf_counter()
        self._process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=self._environment)
        assert self._process.stdout is not None
        for line in self._process.stdout:
            if line.startswith("pages at "):
                self.pages = line.split()[-1]
            if line.startswith("listening on "):
                self.address, self.ready = line.split()[-1], time.perf_counter() - started
                return
        sys.exit(f"the server did not start: it ended with status {self._process.wait()}")

    def kill(self) -> None:
        """Send SIGKILL, and wait until the first process has ended."""
        self._process.kill()
        self._end()

    def stop(self) -> None:
        """Send SIGTERM, and wait until the server has ended."""
        self._process.terminate()
        self._end()

    @property
    def pid(self) -> int:
        """Id of the first process."""
        return self._process.pid

    @property
    def process_ids(self) -> list[int]:
        """Ids of all processes, the first one before the workers; Linux only."""
        children = Path(f"/proc/{self.pid}/task/{self.pid}/children").read_text().split()
        return [self.pid, *map(int, children)]

    @property
    def memory(self) -> float:
        """Resident memory of all processes, including shared memory, in MB."""
        return sum(map(_resident, self.process_ids))

    @property
    def cpu_seconds(self) -> float:
        """CPU seconds that all processes have used so far."""
        return sum(map(cpu_seconds, self.process_ids))

    def _end(self) -> None:
        self._process.wait()
        assert self._process.stdout is not None
        self._process.stdout.close()


@contextmanager
def running_server(
    data: Path, setting: ServerSetting, *, journal: str = "", environment: Mapping[str, str] | None = None
) -> Iterator[MeasuredServer]:
    """Run a server; it is stopped at the end."""
    with tempfile.TemporaryDirectory() as folder:
        server = MeasuredServer(data, setting, Path(folder), journal, environment)
        try:
            yield server
        finally:
            server.stop()


def cpu_seconds(process_id: int) -> float:
    """Return the CPU seconds that a process has used so far; Linux only."""
    fields = Path(f"/proc/{process_id}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def _resident(process_id: int) -> float:
    for line in Path(f"/proc/{process_id}/status").read_text().splitlines():
        if line.startswith("VmRSS:"):
            return int(line.split()[1]) / 1000
    return 0.0  # It has ended, and waits for its parent.
