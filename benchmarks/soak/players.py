"""Players of the soak test: real clients that play one run after another, and resume after every fault."""

import json
import signal
import threading
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from tests.faults.clients import Client, client
from tests.relay import Relay

REST_SECONDS = 0.5
"""Seconds before a client that found no server is restarted."""

NO_SERVER = "no server answers"
"""Message of a client that finds no server: it is restarted, and this does not count as a defect."""


class SoakPlayer:
    """A participant: its client plays one run after another.

    Args:
        target: the server's address.
        output: folder for results.
        access: client arguments for the token file and the certificate authority, if the host requires them.
        settings: further arguments of its clients, for example its sensors.

    Attributes:
        relay: the relay through which its clients connect.
        access, settings: as given.
        run: id of the current run, once it is known.
        finished: ids of its complete runs.
        complaints: messages of clients that failed for other reasons than a missing server.
        refusals: number of clients that found no server and were restarted.
        seconds: time for which its clients ran.
    """

    def __init__(self, target: str, output: Path, access: Sequence[str] = (), settings: Sequence[str] = ()) -> None:
        self.relay = Relay(target)
        self.run = ""
        self.finished: list[str] = []
        self.complaints: list[str] = []
        self.refusals = 0
        self.seconds = 0.0
        self.access, self.settings = access, settings
        self._output = output
        self._process: Client | None = None
        self._ending = threading.Event()
        self._given_up = threading.Event()
        self._thread = threading.Thread(target=self._play_runs)

    def start(self, run: str = "") -> "SoakPlayer":
        """Start playing: only the given run, shared with others, or one new run after another."""
        self.run = run
        if run:
            self.end()
        self._thread.start()
        return self

    def end(self) -> None:
        """Make the current run the last one."""
        self._ending.set()

    def wait(self, seconds: float) -> bool:
        """Wait for the end of the last run; return whether it ended in time."""
        self._thread.join(max(0.0, seconds))
        return not self._thread.is_alive()

    def close(self) -> None:
        """Stop its client and its thread."""
        self.end()
        self._given_up.set()
        self.signal(signal.SIGKILL)
        if self._thread.ident is not None:
            self._thread.join()
        self.relay.close()

    @property
    def is_playing(self) -> bool:
        """Whether its client is running and has a run."""
        return bool(self.run) and self._process is not None and self._process.poll() is None

    def signal(self, number: signal.Signals) -> None:
        """Send a signal to its client, if it is running."""
        if self._process is not None and self._process.poll() is None:
            self._process.send_signal(number)

    def results(self, run: str) -> Any:
        """Return the results file of a run, parsed."""
        return json.loads((self._output / f"{run}.json").read_text())

    def receipt(self, run: str) -> Path:
        """Return the path of a run's receipt."""
        return self._output / f"{run}.receipt.json"

    def _play_runs(self) -> None:
        while True:
            self._play()
            if self._ending.is_set():
                return
            self.run = ""

    def _play(self) -> None:
        """Play a run to its end, with as many clients as necessary."""
        while not self._given_up.is_set():
            more = [*self.settings, *(["--resume", self.run] if self.run else [])]
            started = time.monotonic()
            self._process = client(self.relay.address, self._output, "--quiet", *self.access, *more)
            if self._given_up.is_set():
                self._process.kill()
            said = self._listen(self._process)
            status = self._process.wait()
            self.seconds += time.monotonic() - started
            if status == 0:
                self.finished.append(self.run)
                return
            if status == -signal.SIGKILL:
                continue
            if NO_SERVER in said:
                self.refusals += 1
            else:
                self.complaints.append(f"a client of run {self.run or '?'} ended with status {status}: {said}")
            time.sleep(REST_SECONDS)

    def _listen(self, process: Client) -> str:
        assert process.stdout is not None
        said = []
        with process.stdout:
            for line in process.stdout:
                said.append(line)
                if line.startswith("run ") and not self.run:
                    self.run = line.split()[1].rstrip(":")
        return "".join(said)
