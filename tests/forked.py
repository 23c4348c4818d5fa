"""Server processes for tests, forked from one with all modules loaded, which makes their start quick."""

import multiprocessing
import os
import signal
import subprocess
import sys
import tempfile
import threading
from collections.abc import Mapping, Sequence
from contextlib import suppress
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from server.cli import main

_CONTEXT = multiprocessing.get_context("forkserver")
_CONTEXT.set_forkserver_preload(["tests.loaded"])


class Forked:
    """`arramon-server` with these arguments (`serving.Process`).

    A process like any other, but for its beginning, and its very end: Python's own last steps are left out.
    """

    def __init__(self, arguments: Sequence[str], stdout: "Connection[Any, Any]", stderr: Path) -> None:
        given = (list(arguments), dict(os.environ), stdout, stderr)
        self._process = _CONTEXT.Process(target=_run, args=given, daemon=True)
        self._process.start()
        assert self._process.pid is not None
        self.pid = self._process.pid

    def poll(self) -> int | None:
        return self._process.exitcode

    def send_signal(self, sig: int) -> None:
        if self.poll() is None:
            with suppress(ProcessLookupError):  # it has just ended
                os.kill(self.pid, sig)

    def kill(self) -> None:
        self.send_signal(signal.SIGKILL)

    def wait(self, timeout: float) -> int:
        self._process.join(timeout)
        status = self.poll()
        if status is None:
            raise subprocess.TimeoutExpired("arramon-server", timeout)
        return status


def run(*arguments: object) -> "subprocess.CompletedProcess[str]":
    """`arramon-server` with these arguments, to its end: its status, and what it said."""
    words = list(map(str, arguments))
    said, says = multiprocessing.Pipe(duplex=False)
    with tempfile.NamedTemporaryFile(prefix="arramon-server-") as errors, said:
        with says:
            process = Forked(words, says, Path(errors.name))
        with os.fdopen(os.dup(said.fileno())) as output:
            stdout = output.read()
        return subprocess.CompletedProcess(words, process.wait(240), stdout, Path(errors.name).read_text())


def _run(arguments: list[str], environment: Mapping[str, str], stdout: "Connection[Any, Any]", stderr: Path) -> None:
    os.dup2(stdout.fileno(), sys.stdout.fileno())
    stdout.close()
    with stderr.open("ab") as log:
        os.dup2(log.fileno(), sys.stderr.fileno())
    os.environ.clear()
    os.environ.update(environment)
    threading.Thread(target=_stop_with_parent, daemon=True).start()
    sys.exit(main(arguments))


def _stop_with_parent() -> None:
    """However the tests end, they leave no server behind."""
    parent = multiprocessing.parent_process()
    assert parent is not None
    parent.join()
    os.kill(os.getpid(), signal.SIGTERM)
