"""Servers and clients for tests, forked from a process with all modules loaded, which makes their start quick."""

import faulthandler
import multiprocessing
import os
import signal
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, TextIO

import arramon_client.cli
import arramon_server.__main__
from tests import forked_workers

END_SECONDS = 120.0
"""Time within which a process must end after its last task."""

RUN_SECONDS = 600.0
"""Time within which a whole command must end."""

Main = Callable[[list[str]], int]
"""Runs a command with these arguments; returns its exit status."""

CONTEXT = multiprocessing.get_context("forkserver")
CONTEXT.set_forkserver_preload(["tests.loaded"])


class Forked:
    """`arramon-server` with these arguments (`serving.Process`), or another command.

    A process like any other, but for its beginning, and its very end: Python's own last steps are left out.

    Args:
        arguments: of the command.
        stdout: the writing end of a pipe.
        stderr: file to which standard error is appended; None for standard output.
        command: the command's function.
    """

    def __init__(
        self,
        arguments: Sequence[str],
        stdout: "Connection[Any, Any]",
        stderr: Path | None,
        command: Main = arramon_server.__main__.main,
    ) -> None:
        self._arguments = list(arguments)
        given = (command, self._arguments, dict(os.environ), stdout, stderr)
        self._process = CONTEXT.Process(target=_run, args=given, daemon=True)
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

    def wait(self, timeout: float = END_SECONDS) -> int:
        self._process.join(timeout)
        status = self.poll()
        if status is None:
            self.send_signal(signal.SIGABRT)  # It writes to its standard error where each of its threads was.
            self._process.join(END_SECONDS)
            raise subprocess.TimeoutExpired(self._arguments, timeout)
        return status


class ForkedClient(Forked):
    """`arramon-client` with these arguments, as `subprocess.Popen` would start it with errors on standard output."""

    def __init__(self, arguments: Sequence[str]) -> None:
        said, says = multiprocessing.Pipe(duplex=False)
        with said, says:
            super().__init__(arguments, says, None, arramon_client.cli.main)
            self.stdout = os.fdopen(os.dup(said.fileno()))

    @property
    def returncode(self) -> int | None:
        return self.poll()

    def communicate(self, timeout: float = RUN_SECONDS) -> tuple[str, None]:
        """What it said from now on to its end, or nothing if that was read already."""
        text = "" if self.stdout.closed else read_to_end(self, self.stdout, timeout)
        self.wait()
        return text, None


def run(*arguments: object, command: Main = arramon_server.__main__.main) -> "subprocess.CompletedProcess[str]":
    """`arramon-server` with these arguments, or another command, to its end: its status, and what it said."""
    words = list(map(str, arguments))
    said, says = multiprocessing.Pipe(duplex=False)
    with tempfile.NamedTemporaryFile(prefix="arramon-server-") as errors, said:
        with says:
            process = Forked(words, says, Path(errors.name), command)
        stdout = read_to_end(process, os.fdopen(os.dup(said.fileno())), RUN_SECONDS, Path(errors.name))
        return subprocess.CompletedProcess(words, process.wait(), stdout, Path(errors.name).read_text())


def read_to_end(process: Forked, output: TextIO, timeout: float, errors: Path | None = None) -> str:
    """Read what a process writes until it ends, and close it.

    Raises:
        AssertionError: if it takes too long; it is then aborted, and the message ends with its threads' stacks.
    """
    late = threading.Event()

    def abort() -> None:
        late.set()
        process.send_signal(signal.SIGABRT)

    timer = threading.Timer(timeout, abort)
    timer.start()
    try:
        with output:
            text = output.read()
    finally:
        timer.cancel()
    if late.is_set():
        raise AssertionError(f"a process did not end within {timeout} s: {text}{errors.read_text() if errors else ''}")
    return text


def _run(
    command: Main,
    arguments: list[str],
    environment: Mapping[str, str],
    stdout: "Connection[Any, Any]",
    stderr: Path | None,
) -> None:
    os.dup2(stdout.fileno(), sys.stdout.fileno())
    stdout.close()
    if stderr is None:
        os.dup2(sys.stdout.fileno(), sys.stderr.fileno())
    else:
        with stderr.open("ab") as log:
            os.dup2(log.fileno(), sys.stderr.fileno())
    os.environ.clear()
    os.environ.update(environment)
    faulthandler.enable(2)  # If it is aborted.
    if sys.platform == "linux":
        forked_workers.install()
    threading.Thread(target=_stop_with_parent, daemon=True).start()
    sys.exit(command(arguments))


def _stop_with_parent() -> None:
    """However the tests end, they leave no process behind."""
    parent = multiprocessing.parent_process()
    assert parent is not None
    parent.join()
    os.kill(os.getpid(), signal.SIGTERM)
