"""The soak's players: real clients that play run after run, and go on whatever happens to them."""

import json
import signal
import subprocess
import threading
import time
from pathlib import Path
from typing import Any

from tests.faults.clients import client
from tests.relay import Relay

REST_SECONDS = 0.5
"""Between two starts of a client that found no server."""

NO_SERVER = "no server answers"
"""What a client says that is started, or wants its scores, while there is none: to be tried again, and no defect."""


class Player:
    """One participant: a client that plays a run; when it has ended, another one.

    Attributes:
        relay: through which its clients connect.
        run: that is being played, once that is known.
        finished: its complete runs.
        complaints: what clients said that failed for a reason of their own.
        refusals: clients that found no server and were started again.
    """

    def __init__(self, target: str, output: Path) -> None:
        self.relay = Relay(target)
        self.run = ""
        self.finished: list[str] = []
        self.complaints: list[str] = []
        self.refusals = 0
        self._output = output
        self._process: subprocess.Popen[str] | None = None
        self._ending = threading.Event()
        self._given_up = threading.Event()
        self._thread = threading.Thread(target=self._play_runs)

    def start(self, run: str = "") -> "Player":
        """Begins to play: a run that others play too, and nothing else, or one run after another."""
        self.run = run
        if run:
            self.end()
        self._thread.start()
        return self

    def end(self) -> None:
        """The present run is to be the last one."""
        self._ending.set()

    def wait(self, seconds: float) -> bool:
        """Waits for the end of the last run; returns whether it came in time."""
        self._thread.join(max(0.0, seconds))
        return not self._thread.is_alive()

    def close(self) -> None:
        """Leaves nothing running."""
        self.end()
        self._given_up.set()
        self.signal(signal.SIGKILL)
        if self._thread.ident is not None:
            self._thread.join()
        self.relay.close()

    @property
    def is_playing(self) -> bool:
        """Whether a client of it runs that has a run."""
        return bool(self.run) and self._process is not None and self._process.poll() is None

    def signal(self, number: signal.Signals) -> None:
        """Sends a signal to its client, if one runs."""
        if self._process is not None and self._process.poll() is None:
            self._process.send_signal(number)

    def results(self, run: str) -> Any:
        """What a client wrote down of a run."""
        return json.loads((self._output / f"{run}.json").read_text())

    def receipt(self, run: str) -> Path:
        """Of a run."""
        return self._output / f"{run}.receipt.json"

    def _play_runs(self) -> None:
        while True:
            self._play()
            if self._ending.is_set():
                return
            self.run = ""

    def _play(self) -> None:
        """Plays a run to its end, by as many clients as that takes."""
        while not self._given_up.is_set():
            more = ["--resume", self.run] if self.run else []
            self._process = client(self.relay.address, self._output, "--quiet", *more)
            if self._given_up.is_set():
                self._process.kill()
            said = self._listen(self._process)
            status = self._process.wait()
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

    def _listen(self, process: "subprocess.Popen[str]") -> str:
        assert process.stdout is not None
        said = []
        with process.stdout:
            for line in process.stdout:
                said.append(line)
                if line.startswith("run ") and not self.run:
                    self.run = line.split()[1].rstrip(":")
        return "".join(said)
