"""The embedded server: the evaluation server as a child process on a Unix socket."""

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

from arramon_client.closing import close_once
from arramon_client.errors import EmbeddedServerError

SERVER = "arramon_server"
"""The package that `python -m` runs."""

READY_PREFIX = "listening on "
"""Prefix of the line on the server's standard output that announces that it is ready."""

PAGES_PREFIX = "pages at "
"""Prefix of the line that gives the URL of the server's pages, if it serves any; it comes before the other one."""

START_TIMEOUT, STOP_TIMEOUT = 180.0, 30.0
"""Time limits for starting (apart from a slow first start) and stopping the server, in seconds."""

NOTICE_TIMEOUT = 1800.0
"""Additional time limit after the server has announced a slow first start; it takes 30 seconds on an idle machine."""

NOTICE_PREFIX = "compiling "
"""Prefix of output lines that announce a slow first start, and are shown to the participant."""

SOCKET_PATH_LIMIT = 100
"""Maximum length of a Unix socket's path that every system allows, in characters."""


def default_data() -> Path:
    """Return the default data folder: `$ARRAMON_DATA`, or `arramon-data` in the working directory."""
    return Path(os.environ.get("ARRAMON_DATA") or "arramon-data")


@contextlib.contextmanager
def embedded_server(
    data: Path,
    *,
    module: str = SERVER,
    options: Sequence[str] = (),
    notify: Callable[[str], None] = lambda _: None,
) -> Iterator["EmbeddedServer"]:
    """Start a server on a Unix socket, and stop it at the end of the context, or of the program.

    Args:
        data: the server's data folder.
        module: the package whose `python -m MODULE serve` is the server.
        options: further arguments of `serve`.
        notify: called from another thread with messages for the participant who waits for the server.

    Raises:
        EmbeddedServerError: if the server is not installed, or does not start.
    """
    check_installed(module)
    folder = _short_folder()
    server = EmbeddedServer(folder, data, module, options, notify)

    def stop() -> None:
        server.stop()
        shutil.rmtree(folder, ignore_errors=True)

    close = close_once(server, stop)
    try:
        server.start()
        yield server
    finally:
        close()


def check_installed(module: str) -> None:
    """Raise EmbeddedServerError unless the server's package is installed, on a system on which it runs."""
    if os.name != "posix":
        raise EmbeddedServerError(
            "without --server the client starts an embedded server, which needs Linux or macOS: on Windows use WSL 2, "
            "or name a server with --server HOST:PORT"
        )
    if importlib.util.find_spec(module) is None:
        raise EmbeddedServerError(
            "without --server the client starts an embedded server, but arramon-server is not installed: install it, "
            "or name a server with --server HOST:PORT"
        )


class EmbeddedServer:
    """The process of an embedded server.

    Attributes:
        address: address to connect to; it stays the same when the process is restarted.
        pages: URL of its pages; empty if it serves none.
    """

    def __init__(
        self, folder: Path, data: Path, module: str, options: Sequence[str], notify: Callable[[str], None]
    ) -> None:
        self._notify = notify
        self.pages = ""
        self.address = f"unix:{folder / 'arramon.sock'}"
        self._log = folder / "server.log"
        # `-P` keeps the working directory off the module path: a participant's own `queue.py` is not the library's.
        program = [sys.executable, "-P", "-m", "arramon_client.local.lifeline", module]
        # Its settings file and variables may be those of a public server, whose addresses and limits are not for it.
        own = ["--embedded"] if module == SERVER else []
        self._command = [*program, "serve", "--listen", self.address, "--data", str(data.absolute()), *own, *options]
        self._process: subprocess.Popen[str] | None = None
        self._ready, self._noticed = threading.Event(), threading.Event()

    def start(self) -> None:
        """Start the process and wait until it is ready.

        Raises:
            EmbeddedServerError: if it dies, or is not ready in time.
        """
        self._ready, self._noticed = threading.Event(), threading.Event()
        Path(self.address.removeprefix("unix:")).unlink(missing_ok=True)  # Left behind by a process that was killed.
        with self._log.open("ab") as log:
            # In a new session, an interrupt from the keyboard reaches only the client, which then stops the server.
            self._process = subprocess.Popen(  # noqa: S603 - this interpreter
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
        if not done.wait(START_TIMEOUT) and self._noticed.is_set():
            done.wait(NOTICE_TIMEOUT)
        if not self._ready.is_set():
            self.stop()
            raise EmbeddedServerError(f"the embedded server did not start\n{self._last_lines()}")

    def revive(self) -> None:
        """Restart the process if it has died.

        Raises:
            EmbeddedServerError: if it does not start.
        """
        if self._process is not None and self._process.poll() is not None:
            self.stop()
            self.start()

    def stop(self) -> None:
        """Stop the process and wait for it; a second call does nothing."""
        process, self._process = self._process, None
        if process is None:
            return
        terminate(process, STOP_TIMEOUT)
        if process.stdin is not None:
            process.stdin.close()

    def _watch(self, output: IO[str], ready: threading.Event, done: threading.Event) -> None:
        """Wait for the line that announces that the server is ready; copy all output to the log file."""
        with output, self._log.open("a") as log:
            for line in output:
                log.write(line)
                log.flush()
                if line.startswith(NOTICE_PREFIX):
                    self._noticed.set()
                    self._notify(line.strip())
                if line.startswith(PAGES_PREFIX):
                    self.pages = line.removeprefix(PAGES_PREFIX).strip()
                if line.startswith(READY_PREFIX):
                    ready.set()
                    done.set()
        done.set()

    def _last_lines(self, count: int = 15) -> str:
        lines = self._log.read_text(errors="replace").splitlines()[-count:]
        return "\n".join(lines) or "(no output)"


def terminate(process: "subprocess.Popen[Any]", timeout: float) -> None:
    """Terminate a process and wait for it; kill it after `timeout` seconds."""
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
