"""Worker processes of a forked server, forked from it too, in place of those that the server's own code starts."""

import os
import signal
import subprocess
import sys
import time
import traceback
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NoReturn

from prometheus_client import values

import arramon_server.__main__
from arramon_client.local import lifeline
from arramon_server.process import workers

LAUNCHER = 4
"""Number of words of a worker's command before the server's own arguments: the interpreter and the lifeline."""


class ForkedWorker:
    """`subprocess.Popen` for a worker: the same streams, session, environment and lifeline, but no new interpreter.

    Attributes:
        pid: the process.
        returncode: its exit status, None while it runs or before `poll` or `wait` has seen its end.
        stdin, stdout: this process's ends of its standard input and output.
    """

    def __init__(self, command: Sequence[str], env: Mapping[str, str], **_streams: Any) -> None:
        read_stdin, write_stdin = os.pipe()
        read_stdout, write_stdout = os.pipe()
        self.returncode: int | None = None
        for stream in (sys.stdout, sys.stderr):
            with suppress(OSError):  # On a disk that is full the text stays in the buffer, as without a fork.
                stream.flush()
        self.pid = os.fork()
        if self.pid == 0:
            _work(command, env, read_stdin, write_stdout)
        os.close(read_stdin)
        os.close(write_stdout)
        self.stdin, self.stdout = os.fdopen(write_stdin, "w"), os.fdopen(read_stdout)

    def poll(self) -> int | None:
        if self.returncode is None:
            pid, status = os.waitpid(self.pid, os.WNOHANG)
            self.returncode = os.waitstatus_to_exitcode(status) if pid else None
        return self.returncode

    def wait(self, timeout: float | None = None) -> int:
        until = time.monotonic() + (timeout or 240.0)
        while (status := self.poll()) is None:
            if time.monotonic() > until:
                raise subprocess.TimeoutExpired("a forked worker", timeout or 240.0)
            time.sleep(0.005)
        return status

    def terminate(self) -> None:
        self._send(signal.SIGTERM)

    def kill(self) -> None:
        self._send(signal.SIGKILL)

    def _send(self, number: signal.Signals) -> None:
        if self.poll() is None:
            os.kill(self.pid, number)


def _work(command: Sequence[str], environment: Mapping[str, str], stdin: int, stdout: int) -> NoReturn:
    """In the new process: becomes the worker, and ends with it."""
    status = 1
    try:
        os.setsid()
        for number in (signal.SIGTERM, signal.SIGINT):
            signal.signal(number, signal.SIG_DFL)
        os.dup2(stdin, 0)
        os.dup2(stdout, sys.stdout.fileno())
        _let_go_of_files()
        os.environ.clear()
        os.environ.update(environment)
        # Chosen by the environment when the module was imported:
        values.ValueClass = values.get_value_class()  # type: ignore[no-untyped-call]
        lifeline.stop_with_parent()
        status = arramon_server.__main__.main(list(command[LAUNCHER:]))
        sys.stdout.flush()
    except BaseException:  # noqa: BLE001 - nothing of the parent may go on here
        traceback.print_exc()
    finally:
        sys.stderr.flush()
        os._exit(status)


def _let_go_of_files() -> None:
    """Close the parent's sockets and pipes in this fork: a copy would keep them open. Their numbers stay taken."""
    nothing = os.open(os.devnull, os.O_RDWR)
    for path in list(Path("/proc/self/fd").iterdir()):
        if int(path.name) > 2 and int(path.name) != nothing:
            os.dup2(nothing, int(path.name))


def install() -> None:
    """From now on the workers of this process are forked."""
    names = ("PIPE", "TimeoutExpired")
    stand_in = SimpleNamespace(Popen=ForkedWorker, **{name: getattr(subprocess, name) for name in names})
    workers.subprocess = stand_in  # type: ignore[assignment, attr-defined]
