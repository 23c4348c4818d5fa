"""Rude streams of the soak test, which join the players' runs and disconnect without a proper close."""

import random
import signal
import subprocess
import sys
import threading
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path

from benchmarks.soak.players import SoakPlayer
from benchmarks.soak.rude_stream import PATIENCE, WAYS

PROGRAM = Path(__file__).with_name("rude_stream.py")

MAX_OPEN_STREAMS = 4
"""Streams that may be open at the same time."""


class RudeStreams:
    """Threads that open and abruptly end one stream after another.

    Args:
        players: the streams join their runs.
        credentials: returns a player's token file and certificate authority, or nothing.
        number: number of streams.
        seconds: time over which they are spread.
        chance: random generator that chooses players.

    Attributes:
        ended: number of streams by how they ended.
        refused: number of refused streams by message, for example for a run that had just ended.
    """

    def __init__(
        self,
        players: Sequence[SoakPlayer],
        credentials: Callable[[SoakPlayer], Sequence[str]],
        number: int,
        seconds: float,
        chance: random.Random,
    ) -> None:
        self.ended, self.refused = Counter[str](), Counter[str]()
        self._players, self._credentials, self._chance = players, credentials, chance
        self._number, self._pause = number, seconds / max(1, number)
        self._pause *= MAX_OPEN_STREAMS
        self._begun = 0
        self._lock = threading.Lock()
        self._over = threading.Event()
        self._threads = [threading.Thread(target=self._work) for _ in range(MAX_OPEN_STREAMS)]

    def start(self) -> None:
        """Start the threads."""
        for thread in self._threads:
            thread.start()

    def wait(self) -> None:
        """Wait for the last stream."""
        for thread in self._threads:
            thread.join()

    def close(self) -> None:
        """Stop the threads."""
        self._over.set()
        for thread in self._threads:
            if thread.ident is not None:
                thread.join()

    def _work(self) -> None:
        while (way := self._next_way()) and not self._over.wait(self._pause):
            playing = [player for player in self._players if player.is_playing]
            while not playing and not self._over.wait(0.2):
                playing = [player for player in self._players if player.is_playing]
            if not playing:
                return
            player = self._chance.choice(playing)
            command = [sys.executable, str(PROGRAM), player.relay.target, player.run, way, *self._credentials(player)]
            done = subprocess.run(command, capture_output=True, text=True, timeout=4 * PATIENCE, check=False)
            if done.returncode in (0, -signal.SIGKILL if way == "killed" else 0):
                self.ended[way] += 1
            else:
                self.refused[(done.stderr.strip().splitlines() or ["no message"])[-1]] += 1

    def _next_way(self) -> str:
        """Return how the next stream should end; empty after enough streams, or after too many refusals."""
        with self._lock:
            refused = sum(self.refused.values())
            if self._begun >= self._number + refused or refused > self._number:
                return ""
            self._begun += 1
            return WAYS[self._begun % len(WAYS)]
