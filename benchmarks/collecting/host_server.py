"""The server of a simulated collection, which is killed and started again at the same address."""

import os
import random
import socket
import subprocess
import sys
import time
import urllib.request
from contextlib import suppress
from pathlib import Path

START_SECONDS = 120.0


class HostServer:
    """`arramon-server serve` with pages on a free port of this machine.

    Args:
        data: data folder; the journal is in it.
        kills: how often the server is killed, at random moments.
        seed: of the random moments.

    Attributes:
        site: address of the pages.
        kills_left: number of kills that are still to come.
    """

    def __init__(self, data: Path, kills: int, seed: int) -> None:
        self._data = data
        self._random = random.Random(seed)  # noqa: S311 - of a simulation
        self.kills_left = kills
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self._address = f"127.0.0.1:{free.getsockname()[1]}"
        self.site = f"http://{self._address}"
        self._process: subprocess.Popen[bytes] | None = None

    def start(self) -> None:
        """Start the process, and wait until it serves pages.

        Raises:
            RuntimeError: if it ends, or serves none in time.
        """
        with (self._data / "server.log").open("ab") as log:
            self._process = subprocess.Popen(self._command(), stdout=log, stderr=log, env=os.environ)
        until = time.monotonic() + START_SECONDS
        while time.monotonic() < until:
            if self._process.poll() is not None:
                break
            with suppress(OSError), urllib.request.urlopen(f"{self.site}/en/", timeout=10):  # noqa: S310 - its own address
                return
            time.sleep(0.2)
        raise RuntimeError(f"the server does not serve {self.site}; see {self._data / 'server.log'}")

    def stop(self) -> None:
        """End the process in an orderly way."""
        if self._process is not None:
            self._process.terminate()
            self._process.wait(60.0)
            self._process = None

    def maybe_kill(self, chance: float) -> bool:
        """Kill and restart the server with a probability, while kills are left; return whether it was killed."""
        if not self.kills_left or self._random.random() >= chance:
            return False
        self.kills_left -= 1
        assert self._process is not None
        self._process.kill()
        self._process.wait(60.0)
        self.start()
        return True

    def _command(self) -> list[str]:
        options = ["--data", str(self._data), "--listen", "127.0.0.1:0", "--web", self._address]
        return [sys.executable, "-m", "arramon_server", "serve", *options]
