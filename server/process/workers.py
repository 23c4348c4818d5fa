"""Worker processes that serve on one address: starting, restarting and stopping them.

Over TCP they share the port (SO_REUSEPORT), and on the loopback each also has an address of its own. A Unix socket
cannot be shared: the first worker listens on the path itself, the others on the path with their number.
`ServerInfo.addresses` lists the workers' own addresses, so that a client can spread its streams.
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

from arramon_server.addresses import check_address_free
from arramon_server.configuration.config import Config
from arramon_server.configuration.sources import environment_of, without_settings
from arramon_server.errors import BadInput, Unavailable
from arramon_server.process.prometheus_metrics import FOLDER as METRICS_FOLDER

START_SECONDS = 120.0
"""Time within which a worker must start; it may have to compile the camera."""

STOP_SECONDS = 20.0
"""Time within which a worker must stop, in addition to the time for draining."""

RESTARTS = 5
"""Consecutive early deaths after which a worker counts as failing, and is restarted with growing delays."""

EARLY_SECONDS = 60.0
"""A death within this time after the start counts as early."""

MAX_DELAY = 30.0
"""Maximum delay before a failing worker is restarted."""

_log = logging.getLogger(__name__)


def own_address(listen: str, number: int) -> str:
    """Return the address that only worker `number` listens on; empty if it has none."""
    if listen.startswith("unix:"):
        return f"{listen}.{number}"
    host = listen.rpartition(":")[0]
    return f"{host}:0" if host in ("127.0.0.1", "localhost", "[::1]") else ""


def serve_with_workers(config: Config, announce: Callable[[str], None]) -> None:
    """Serve with several processes until SIGTERM or SIGINT.

    Args:
        config: the host's settings; every process gets the same ones, apart from its own address.
        announce: called with a line for each address, once all workers listen.

    Raises:
        BadInput: if an address cannot be listened on.
        Unavailable: if a worker does not start, or later all of them keep dying.
    """
    stopping, workers = threading.Event(), list[_Worker]()

    def stop(*_: object) -> None:
        if stopping.is_set():  # A second signal ends the workers at once.
            for worker in workers:
                worker.terminate()
        stopping.set()

    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, stop)
    with ExitStack() as stack:
        address = stack.enter_context(_reserved(config.listen))
        web = stack.enter_context(_reserved(config.web))
        metrics = web if config.metrics == config.web else stack.enter_context(_reserved(config.metrics))
        config = replace(config, listen=address, web=web, metrics=metrics)
        environment = environment_of(replace(config, workers=1))
        # Every worker writes its metrics to this folder, and reads the metrics of the others.
        environment[METRICS_FOLDER] = stack.enter_context(TemporaryDirectory(prefix="arramon-metrics-"))
        stop_seconds = config.drain_seconds + STOP_SECONDS
        workers += [_Worker(number, address, environment, stop_seconds) for number in range(config.workers)]
        try:
            for worker in workers:
                worker.start()
            for worker in workers:
                worker.wait_until_ready(stopping)
            if stopping.is_set():
                return
            for name, place in config.http.items():
                announce(f"{name} at {place}")
            announce(f"listening on {address}")
            # This must not wait for `stopping`: the signal handler runs in this thread and would block on its lock.
            while not stopping.is_set():
                _restart_dead(workers)
                time.sleep(0.2)
        finally:
            for worker in workers:
                worker.terminate()
            for worker in workers:
                worker.end()


def _restart_dead(workers: Sequence["_Worker"]) -> None:
    """Restart workers that have died.

    Raises:
        Unavailable: if all workers are failing.
    """
    for worker in workers:
        worker.restart_if_dead()
    if all(worker.failing for worker in workers):
        raise Unavailable("all workers keep dying soon after their start; see the log above")


@contextmanager
def _reserved(listen: str) -> Iterator[str]:
    """Keep other processes from taking the shared port while the block runs; yield the address with its actual port."""
    if not listen or listen.startswith("unix:"):
        yield listen
        return
    host, _, port = listen.rpartition(":")
    family = socket.AF_INET6 if host.startswith("[") else socket.AF_INET
    check_address_free(listen)
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

    def __init__(self, number: int, listen: str, environment: Mapping[str, str], stop_seconds: float) -> None:
        # Only the first worker listens on a Unix socket's path; the others have only their own.
        own = own_address(listen, number)
        shared = own if listen.startswith("unix:") and number else listen
        self._number = number
        # The client's lifeline ends the process if its parent ends in any way.
        program = [sys.executable, "-m", "arramon_client.local.lifeline", "arramon_server", "serve"]
        self._command = [*program, "--listen", shared, "--shared-port"]
        if own and own != shared:
            self._command += ["--own-address", own]
        self._environment = {**without_settings(os.environ), **environment}
        self._stop_seconds = stop_seconds
        self._deaths, self._has_started = 0, False
        self._restart_at: float | None = None  # time to restart the process, if it has died

    @property
    def failing(self) -> bool:
        """Whether the worker has died early more than `RESTARTS` times in a row and has not recovered yet."""
        return self._deaths > RESTARTS and (self._restart_at is not None or self._age() < EARLY_SECONDS)

    def _age(self) -> float:
        return time.monotonic() - self._started

    def start(self) -> None:
        self._ready = threading.Event()
        self._started = time.monotonic()
        # In a session of its own: an interrupt from the keyboard reaches only the parent, which then stops the workers.
        pipe = subprocess.PIPE
        self.process = subprocess.Popen(  # noqa: S603 - the interpreter that runs this very program
            self._command, env=self._environment, stdin=pipe, stdout=pipe, text=True, start_new_session=True
        )
        self._has_started = True
        threading.Thread(target=self._listen, args=(self.process, self._ready), daemon=True).start()

    def terminate(self) -> None:
        """Send SIGTERM to the process, if it was started."""
        if self._has_started:
            self.process.terminate()

    def wait_until_ready(self, stopping: threading.Event) -> None:
        """Wait until the process serves, or `stopping` is set.

        Raises:
            Unavailable: if the process dies first, or takes too long.
        """
        while not self._ready.wait(0.1) and not stopping.is_set():
            if self.process.poll() is not None or self._age() > START_SECONDS:
                raise Unavailable(f"worker {self._number} did not start; its own message is above")

    def restart_if_dead(self) -> None:
        """Restart the process if it has died: at once, or with growing delays while it is failing."""
        if self._restart_at is not None:
            if time.monotonic() >= self._restart_at:
                self._restart_at = None
                self.start()
        elif self.process.poll() is not None:
            self._deaths = self._deaths + 1 if self._age() < EARLY_SECONDS else 1
            delay = min(2.0 ** (self._deaths - RESTARTS), MAX_DELAY) if self._deaths > RESTARTS else 0.0
            _log.error(
                "worker %d died with status %d, %d times in a row; restarting it%s",
                self._number,
                self.process.returncode,
                self._deaths,
                f" in {delay:.0f} s" if delay else "",
            )
            self.end()
            self._restart_at = time.monotonic() + delay

    def end(self) -> None:
        """Wait until the process has ended; kill it if it takes too long."""
        if not self._has_started:
            return
        try:
            self.process.wait(self._stop_seconds)
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
