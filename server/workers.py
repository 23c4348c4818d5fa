"""Several server processes on one address: starts them, starts anew what dies, and stops them all.

Over TCP they share the port (SO_REUSEPORT), and on the loopback each has an address of its own beside it. A Unix socket
cannot be shared: the first listens on the path itself, the others on the path with their number. The addresses of their
own are in `ServerInfo.addresses`, so that a client can spread its streams.
"""

import logging
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from tempfile import TemporaryDirectory

from prometheus_client.multiprocess import mark_process_dead

from server.addresses import check_free
from server.config import Config
from server.configuring import environment_of, without_settings
from server.errors import BadInput, Unavailable
from server.metrics import FOLDER as METRICS_FOLDER

START_SECONDS = 120.0
"""How long a worker may take to start: the first one may have the camera to compile."""

STOP_SECONDS = 20.0
"""How long a worker may take to stop, beyond the time for draining."""

RESTARTS = 5
"""Deaths in a row, each soon after the start, after which a worker is failing: it is started later and later then."""

SOON_SECONDS = 60.0
"""How soon after its start a worker's death counts as one in a row."""

LAST_DELAY = 30.0
"""The longest wait before a failing worker is started again."""

_log = logging.getLogger(__name__)


def own_address(listen: str, number: int) -> str:
    """The address that worker `number` has for itself; empty where it has none."""
    if listen.startswith("unix:"):
        return f"{listen}.{number}"
    host = listen.rpartition(":")[0]
    return f"{host}:0" if host in ("127.0.0.1", "localhost", "[::1]") else ""


def serve_with_workers(config: Config, announce: Callable[[str], None]) -> None:
    """Serves with several processes until SIGTERM or SIGINT.

    Args:
        config: the host's settings; each process gets the very same, but for addresses of its own.
        announce: told where the server listens, once all do.

    Raises:
        BadInput: if the address cannot be listened on.
        Unavailable: if a worker does not start, or later all of them die again and again.
    """
    stopping, workers = threading.Event(), list[_Worker]()

    def stop(*_: object) -> None:
        if stopping.is_set():  # whoever asks a second time does not want to wait
            for worker in workers:
                worker.process.terminate()
        stopping.set()

    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, stop)
    with ExitStack() as stack:
        address = stack.enter_context(_reserved(config.listen))
        web = stack.enter_context(_reserved(config.web))
        metrics = web if config.metrics == config.web else stack.enter_context(_reserved(config.metrics))
        config = replace(config, listen=address, web=web, metrics=metrics)
        environment = environment_of(replace(config, workers=1))
        # There each writes what it counts, and finds what the others have.
        environment[METRICS_FOLDER] = stack.enter_context(TemporaryDirectory(prefix="arramon-metrics-"))
        patience = config.drain_seconds + STOP_SECONDS
        workers += [_Worker(number, address, environment, patience) for number in range(config.workers)]
        try:
            for worker in workers:
                worker.start()
            for worker in workers:
                worker.wait_until_ready()
            for name, place in config.http.items():
                announce(f"{name} at {place}")
            announce(f"listening on {address}")
            # Nobody waits for `stopping` itself: the signal's handler runs in this thread, and would wait for its lock.
            while not stopping.is_set():
                _look_after(workers)
                time.sleep(0.2)
        finally:
            for worker in workers:
                worker.process.terminate()
            for worker in workers:
                worker.end()


def _look_after(workers: Sequence["_Worker"]) -> None:
    """Starts anew what has died; raises Unavailable if that is of no use for any of them."""
    for worker in workers:
        worker.look_after()
    if all(worker.failing for worker in workers):
        raise Unavailable("all workers die soon after their start, again and again; see the log above")


@contextmanager
def _reserved(listen: str) -> Iterator[str]:
    """Holds the shared port, so that nobody else takes it while workers come and go; port 0 becomes a real one."""
    if not listen or listen.startswith("unix:"):
        yield listen
        return
    host, _, port = listen.rpartition(":")
    family = socket.AF_INET6 if host.startswith("[") else socket.AF_INET
    check_free(listen)
    with socket.socket(family) as holder:
        holder.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        holder.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)
        try:
            holder.bind((host.strip("[]"), int(port)))
        except OSError as error:
            raise BadInput(f"cannot listen on {listen!r}: {error.strerror}") from error
        yield f"{host}:{holder.getsockname()[1]}"


class _Worker:
    """One server process."""

    process: "subprocess.Popen[str]"

    def __init__(self, number: int, listen: str, environment: Mapping[str, str], patience: float) -> None:
        # A Unix socket belongs to the first worker; the others have only their own.
        own = own_address(listen, number)
        shared = own if listen.startswith("unix:") and number else listen
        self._number = number
        # The client's lifeline ends a process whose parent is gone, however it went.
        program = [sys.executable, "-m", "arramon_client.lifeline", "server", "serve"]
        self._command = [*program, "--listen", shared, "--shared-port"]
        if own and own != shared:
            self._command += ["--own-address", own]
        self._environment = {**without_settings(os.environ), **environment}
        self._patience = patience
        self._deaths = 0
        self._again_at: float | None = None  # when to start the process that has died

    @property
    def failing(self) -> bool:
        """Whether it has died too often in a row, and has not lived for long since."""
        return self._deaths > RESTARTS and (self._again_at is not None or self._lived() < SOON_SECONDS)

    def _lived(self) -> float:
        return time.monotonic() - self._started

    def start(self) -> None:
        self._ready = threading.Event()
        self._started = time.monotonic()
        # A session of its own: an interrupt at the keyboard is for the parent, which then stops the workers.
        pipe = subprocess.PIPE
        self.process = subprocess.Popen(  # noqa: S603 - the interpreter that runs this very program
            self._command, env=self._environment, stdin=pipe, stdout=pipe, text=True, start_new_session=True
        )
        threading.Thread(target=self._listen, args=(self.process, self._ready), daemon=True).start()

    def wait_until_ready(self) -> None:
        """Raises Unavailable if the process dies first, or takes too long."""
        while not self._ready.wait(0.1):
            if self.process.poll() is not None or self._lived() > START_SECONDS:
                raise Unavailable(f"worker {self._number} did not start; its own message stands above")

    def look_after(self) -> None:
        """Starts the process anew if it has died: at once, but later and later while it is failing."""
        if self._again_at is not None:
            if time.monotonic() >= self._again_at:
                self._again_at = None
                self.start()
        elif self.process.poll() is not None:
            self._deaths = self._deaths + 1 if self._lived() < SOON_SECONDS else 1
            delay = min(2.0 ** (self._deaths - RESTARTS), LAST_DELAY) if self._deaths > RESTARTS else 0.0
            _log.error(
                "worker %d died with status %d, %d times in a row; starting it again%s",
                self._number,
                self.process.returncode,
                self._deaths,
                f" in {delay:.0f} s" if delay else "",
            )
            self.end()
            self._again_at = time.monotonic() + delay

    def end(self) -> None:
        """Waits until the process is gone; kills it if it does not go."""
        try:
            self.process.wait(self._patience)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        mark_process_dead(self.process.pid, self._environment[METRICS_FOLDER])  # type: ignore[no-untyped-call]
        if self.process.stdin is not None:
            self.process.stdin.close()

    @staticmethod
    def _listen(process: "subprocess.Popen[str]", ready: threading.Event) -> None:
        assert process.stdout is not None
        for line in process.stdout:
            if line.startswith("listening on "):
                ready.set()
        process.stdout.close()
