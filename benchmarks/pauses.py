"""Seconds for which an episode stands still when a process of the server ends, and others or its successor go on.

    python benchmarks/pauses.py [--data DIR] [--rounds 5] [--parallel 16] [--json FILE]

A real client plays over TCP. In each round a process of the server is told to stop, or is killed: one of two workers,
and the only one, which is started again at once. The rows show how long the episodes waited that were open then, beside
the longest wait of any of them while nothing happened.
"""

import argparse
import json
import os
import signal
import statistics
import sys
import threading
import time
from collections.abc import Callable, Iterable, Sequence
from contextlib import ExitStack
from pathlib import Path
from tempfile import TemporaryDirectory

sys.path.insert(0, str(Path(__file__).parents[1]))  # the tests start and kill servers, too

from common import data_or_sample
from serving import Timed, family, warm_up

from arramon.v1 import evaluation_pb2, types_pb2
from arramon_client.agent import Action, Observation
from arramon_client.connection import METADATA, connect
from arramon_client.lanes import play_in_lanes
from arramon_client.play import Settings
from server.episodes.splits import read_splits
from tests.serving import Server

PATIENCE = 60.0
"""Seconds after which an episode that stands still is given up."""


class Seen(Timed):
    """Turns on the spot, so that no episode is soon over, and notes when each was last seen."""

    def act(self, observations: Sequence[Observation]) -> Sequence[int]:
        """Left, always."""
        super().act(observations)
        now = time.perf_counter()
        for observation in observations:
            before = self.last.get(observation.episode_id, now)
            self.longest[observation.episode_id] = max(self.longest.get(observation.episode_id, 0.0), now - before)
            self.last[observation.episode_id] = now
        return [Action.LEFT] * len(observations)

    def reset(self) -> None:
        """Forgets what was noted so far."""
        super().reset()
        self.last: dict[str, float] = {}
        self.longest: dict[str, float] = {}


def drained(server: Server) -> None:
    """One of two workers is told to stop."""
    os.kill(family(server.process.pid)[1], signal.SIGTERM)


def killed(server: Server) -> None:
    """One of two workers is killed."""
    os.kill(family(server.process.pid)[1], signal.SIGKILL)


def started_again(server: Server) -> None:
    """The only process is killed, and another is started on its port."""
    server.kill()
    server.start()


ROWS: dict[str, tuple[int, Callable[[Server], None]]] = {
    "a worker of two drains": (2, drained),
    "a worker of two is killed": (2, killed),
    "the only process is killed, and started again": (1, started_again),
}


def measure(data: Path, split: str, language: str, parallel: int, row: str) -> tuple[float, float]:
    """One round: the longest wait of an episode for its next observation, when nothing happens, and over the fault."""
    workers, fault = ROWS[row]
    with ExitStack() as stack:
        folder = Path(stack.enter_context(TemporaryDirectory()))
        server = Server(
            data, "127.0.0.1:0", "--workers", str(workers), "--journal", f"sqlite:///{folder}/journal.db", "--no-fsync"
        )
        stack.callback(server.stop)
        there = stack.enter_context(connect(server.address))
        request = evaluation_pb2.CreateRunRequest(agent="benchmark", split=split, language=language)
        request.sensors.extend(("rgb", "depth"))
        run = there.stub.CreateRun(request, metadata=METADATA)
        agent = Seen()
        agent.reset()
        settings = Settings(min(parallel, run.episodes), types_pb2.ENCODING_RAW)
        playing = threading.Thread(target=play_in_lanes, args=(there, run, agent, settings), daemon=True)
        playing.start()
        warm_up(agent, settings.parallel)
        agent.reset()
        time.sleep(3.0)
        quiet, open_then = max(agent.longest.values()), dict(agent.last)
        agent.longest, moment = {}, time.perf_counter()
        fault(server)
        wait_for_all(agent, open_then, moment)
        longest = max(agent.longest[episode] for episode in open_then)
        there.stub.CancelRun(evaluation_pb2.CancelRunRequest(run_id=run.run_id), metadata=METADATA)
        playing.join()
    return quiet, longest


def wait_for_all(agent: Seen, episodes: Iterable[str], fault: float) -> None:
    """Waits until each of these has been seen for a second after the fault, or again after that."""
    while left := [episode for episode in episodes if agent.last[episode] < fault + 1.0]:
        if time.perf_counter() > fault + PATIENCE:
            raise SystemExit(f"{len(left)} episodes have stood still for {PATIENCE:.0f} seconds")
        time.sleep(0.05)


def main() -> None:
    """Runs the benchmark and prints its table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--data", type=Path, help="data folder (default: the sample episodes)")
    parser.add_argument("--rounds", type=int, default=5, help="of each row (default: %(default)s)")
    parser.add_argument("--parallel", type=int, default=16, help="episodes open at once (default: %(default)s)")
    parser.add_argument("--json", type=Path, help="file for the figures")
    options = parser.parse_args()
    with data_or_sample(options.data) as data:
        split = max(read_splits(data).values(), key=lambda split: len(split.episodes))
        language = next(iter(split.languages))
        found: dict[str, list[tuple[float, float]]] = {row: [] for row in ROWS}
        for _ in range(options.rounds):
            for row in ROWS:
                found[row].append(measure(data, split.name, language, options.parallel, row))
    print(f"{'longest wait of an episode, seconds':48} {'quiet':>7} {'median':>7} {'max':>7}")
    for row, pairs in found.items():
        quiet, longest = zip(*pairs, strict=True)
        print(f"{row:48} {statistics.median(quiet):7.3f} {statistics.median(longest):7.2f} {max(longest):7.2f}")
    if options.json:
        options.json.write_text(json.dumps(found, indent=1))


if __name__ == "__main__":
    main()
