"""A real server in its own process, which tests start, kill, and restart on the same address."""

import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, ClassVar, Protocol

from arramon.v1 import PROTOCOL, PROTOCOL_METADATA
from tests.ports import free_port

METADATA = ((PROTOCOL_METADATA, str(PROTOCOL)),)


class Process(Protocol):
    """What `subprocess.Popen` has that tests need."""

    pid: int

    def poll(self) -> int | None: ...
    def send_signal(self, sig: int) -> None: ...
    def kill(self) -> None: ...
    def wait(self, timeout: float) -> int: ...


class Fork(Protocol):
    """Starts `arramon-server` with these arguments."""

    def __call__(self, arguments: Sequence[str], stdout: "Connection[Any, Any]", stderr: Path) -> Process: ...


class Server:
    """`arramon-server serve` on a data folder. Without an address it takes a free port of the loopback, and keeps it.

    What it writes to standard error is appended to the file `log`, if there is one. With `anew`, or with variables for
    the environment, the process is started as an operator starts it, whatever `fork` says.
    """

    fork: ClassVar[Fork | None] = None
    """What starts processes; None for the command."""

    def __init__(
        self,
        data: Path,
        listen: str = "127.0.0.1:0",
        *more: str,
        log: Path | None = None,
        environment: Mapping[str, str] | None = None,
        anew: bool = False,
    ) -> None:
        if listen == "127.0.0.1:0":
            listen = f"127.0.0.1:{free_port(holder=self)}"  # or another might have it when the server is started again
        self.data, self.listen, self.more, self.log = data, listen, more, log
        self._environment, self._anew = {**os.environ, **(environment or {})}, anew or environment is not None
        self.start()

    def start(self) -> None:
        with tempfile.NamedTemporaryFile(prefix="arramon-server-") as unnamed:
            log = self.log or Path(unnamed.name)
            said, says = Pipe(duplex=False)
            with said, says:
                self.process = self._started(says, log)
                self._said = os.fdopen(os.dup(said.fileno()))
            self.said = []
            for line in self._said:
                self.said.append(line.strip())
                if line.startswith("listening on "):
                    self.listen = self.address = line.removeprefix("listening on ").strip()
                    return
            self.wait()
            raise AssertionError(f"the server did not start: {log.read_text()[-2000:]}")

    def kill(self) -> None:
        self.process.kill()
        self.wait()

    def stop(self) -> int:
        self.process.send_signal(signal.SIGTERM)
        return self.wait()

    def wait(self, timeout: float = 120.0) -> int:
        """The exit status, once it has ended."""
        try:
            return self.process.wait(timeout)
        except subprocess.TimeoutExpired:
            self.process.kill()  # or it would disturb what comes after
            self.process.wait(timeout)
            raise
        finally:
            self._said.close()

    def _started(self, says: "Connection[Any, Any]", log: Path) -> Process:
        arguments = ["serve", "--data", str(self.data), "--listen", self.listen, *self.more]
        if self.fork is not None and not self._anew:
            return self.fork(arguments, says, log)
        command = [sys.executable, "-m", "arramon_server", *arguments]
        with log.open("ab") as errors:
            return subprocess.Popen(command, env=self._environment, stdout=says.fileno(), stderr=errors)
