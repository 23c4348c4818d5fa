"""A real server in a process of its own, for tests: started, killed and started again on the same address."""

import os
import signal
import subprocess
import sys
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path

from arramon.v1 import PROTOCOL, PROTOCOL_METADATA

METADATA = ((PROTOCOL_METADATA, str(PROTOCOL)),)


class Server:
    """`arramon-server serve` on a data folder. Without an address it takes a free port of the loopback.

    What it writes to standard error is kept in a pipe, or goes to the file `log`, where it may be much.
    """

    def __init__(
        self,
        data: Path,
        listen: str = "127.0.0.1:0",
        *more: str,
        log: Path | None = None,
        environment: Mapping[str, str] | None = None,
    ) -> None:
        self.data, self.listen, self.more, self.log = data, listen, more, log
        self.environment = {**os.environ, **(environment or {})}
        self.start()

    def start(self) -> None:
        command = [
            sys.executable,
            "-m",
            "server",
            "serve",
            "--data",
            str(self.data),
            "--listen",
            self.listen,
            *self.more,
        ]
        with ExitStack() as stack:
            stderr = subprocess.PIPE if self.log is None else stack.enter_context(self.log.open("a"))
            self.process = subprocess.Popen(
                command, stdout=subprocess.PIPE, stderr=stderr, text=True, env=self.environment
            )
        assert self.process.stdout is not None
        self.said = []
        for line in self.process.stdout:
            self.said.append(line.strip())
            if line.startswith("listening on "):
                self.listen = self.address = line.removeprefix("listening on ").strip()
                return
        errors = self.process.communicate()[1] if self.log is None else self.log.read_text()[-2000:]
        raise AssertionError(f"the server did not start: {errors}")

    def kill(self) -> None:
        self.process.kill()
        self._gone()

    def stop(self) -> int:
        self.process.send_signal(signal.SIGTERM)
        return self._gone()

    def _gone(self) -> int:
        self.process.communicate(timeout=20)
        return self.process.returncode
