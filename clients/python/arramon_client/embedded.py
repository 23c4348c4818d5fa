"""The embedded server: the same server as a remote one, as a process of its own on a Unix socket of this machine."""

import contextlib
import importlib.util
import os
import shutil
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import IO, Any

from arramon_client.errors import EmbeddedServerError

READY = "listening on "
"""How the line on the server's standard output begins that says it is ready."""

START_TIMEOUT, STOP_TIMEOUT = 180.0, 30.0
"""Seconds that the server may take to start and to stop."""

NOTICE = "compiling "
"""How a line begins there that whoever waits should read: the first start on a machine takes long."""

SOCKET_PATH_LIMIT = 100
"""Characters that a Unix socket's path may have on every system."""


def default_data() -> Path:
    """The data folder where none is named: `$ARRAMON_DATA`, or `arramon-data` in the working directory."""
    return Path(os.environ.get("ARRAMON_DATA") or "arramon-data")


@contextlib.contextmanager
def embedded_server(
    data: Path,
    *,
    module: str = "server",
    options: Sequence[str] = (),
    notify: Callable[[str], None] = lambda _: None,
) -> Iterator["EmbeddedServer"]:
    """Starts a server on a Unix socket, and stops it at the end.

    Args:
        data: its data folder.
        module: the package whose `python -m MODULE serve` is the server.
        options: further arguments of `serve`.
        notify: is told, by another thread, what a participant who waits for the server should read.

    Raises:
        EmbeddedServerError: if the server is not installed, or does not start.
    """
    check_installed(module)
    folder = _short_folder()
    server = EmbeddedServer(folder, data, module, options, notify)
    try:
        server.start()
        yield server
    finally:
        server.stop()
        shutil.rmtree(folder, ignore_errors=True)


def check_installed(module: str) -> None:
    """Raises EmbeddedServerError if there is no such package to run a server from."""
    if importlib.util.find_spec(module) is None:
        raise EmbeddedServerError(
            "without --server the client starts a server itself, and none is installed here: install arramon-server, "
            "or name a server with --server HOST:PORT"
        )


class EmbeddedServer:
    """A server process.

    Attributes:
        address: to connect to; the same for every process that is started in place of one that died.
    """

    def __init__(
        self, folder: Path, data: Path, module: str, options: Sequence[str], notify: Callable[[str], None]
    ) -> None:
        self._notify = notify
        self.address = f"unix:{folder / 'arramon.sock'}"
        self._log = folder / "server.log"
        # `-P` keeps the working directory out of the way: a participant's own `server.py` is not meant.
        program = [sys.executable, "-P", "-m", "arramon_client.lifeline", module]
        self._command = [*program, "serve", "--listen", self.address, "--data", str(data.absolute()), *options]
        self._process: subprocess.Popen[str] | None = None
        self._ready = threading.Event()

    def start(self) -> None:
        """Starts the process and waits until it is ready.

        Raises:
            EmbeddedServerError: if it dies, or is not ready in time.
        """
        self._ready = threading.Event()
        Path(self.address.removeprefix("unix:")).unlink(missing_ok=True)  # Of a process that was killed.
        with self._log.open("ab") as log:
            # A session of its own: an interrupt at the keyboard is for the client, which then stops the server.
            self._process = subprocess.Popen(  # noqa: S603 - the interpreter that runs this very program
                self._command,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=log,
                text=True,
                start_new_session=True,
            )
        assert self._process.stdout is not None
        done = threading.Event()
        threading.Thread(
            target=self._watch, args=(self._process.stdout, self._ready, done), name="embedded-server", daemon=True
        ).start()
        done.wait(START_TIMEOUT)
        if not self._ready.is_set():
            self.stop()
            raise EmbeddedServerError(f"the embedded server did not start\n{self._last_lines()}")

    def revive(self) -> None:
        """Starts the process again if it has died.

        Raises:
            EmbeddedServerError: if it does not start any more.
        """
        if self._process is not None and self._process.poll() is not None:
            self.stop()
            self.start()

    def stop(self) -> None:
        """Asks the process to stop and waits for it; a second call does nothing."""
        process, self._process = self._process, None
        if process is None:
            return
        end(process, STOP_TIMEOUT)
        if process.stdin is not None:
            process.stdin.close()

    def _watch(self, output: IO[str], ready: threading.Event, done: threading.Event) -> None:
        """Notices the line that says the server is ready, and keeps the rest of what it says."""
        with output, self._log.open("a") as log:
            for line in output:
                log.write(line)
                log.flush()
                if line.startswith(NOTICE):
                    self._notify(line.strip())
                if line.startswith(READY):
                    ready.set()
                    done.set()
        done.set()

    def _last_lines(self, count: int = 15) -> str:
        lines = self._log.read_text(errors="replace").splitlines()[-count:]
        return "\n".join(lines) or "it said nothing"


def end(process: "subprocess.Popen[Any]", timeout: float) -> None:
    """Asks a process to stop and waits for it; after `timeout` seconds it is killed."""
    process.terminate()
    try:
        process.wait(timeout)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def _short_folder() -> Path:
    folder = Path(tempfile.mkdtemp(prefix="arramon-"))
    if len(str(folder / "arramon.sock")) <= SOCKET_PATH_LIMIT:
        return folder
    folder.rmdir()
    return Path(tempfile.mkdtemp(prefix="arramon-", dir="/tmp"))
