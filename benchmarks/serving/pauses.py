"""Interruption of episodes, in seconds, when a server process ends and others or its successor continue.

    python -m benchmarks.serving.pauses [--data DIR] [--rounds 5] [--parallel 16] [--json FILE]

A real client plays over TCP. In each round a server process is stopped or killed: one of two workers, or the only
process, which is restarted at once. The rows show the waits of the episodes that were open then, and the longest wait
of any of them without a disturbance.
"""

import argparse
import json
import os
import signal
import statistics
import threading
import time
from collections.abc import Callable, Iterable, Sequence
from contextlib import ExitStack
from pathlib import Path
from tempfile import TemporaryDirectory

from arramon.v1 import evaluation_pb2, types_pb2
from arramon_client.agent import Action, Observation
from arramon_client.multi_stream import play_streams
from arramon_client.play import Settings
from arramon_client.transport.connection import METADATA, connect
from arramon_server.episodes.splits import read_splits
from benchmarks.common import data_or_sample
from benchmarks.serving.steps import Timed, family, warm_up
from tests.serving import Server

PATIENCE = 60.0
"""Seconds without an observation after which the benchmark fails."""


class TurningAgent(Timed):
    """An agent that only turns, so that episodes last long, and records each one's latest observation."""

    def act(self, observations: Sequence[Observation]) -> Sequence[int]:
        """Return LEFT for every observation."""
        super().act(observations)
        now = time.perf_counter()
        for observation in observations:
            before = self.last.get(observation.episode_id, now)
            self.longest[observation.episode_id] = max(self.longest.get(observation.episode_id, 0.0), now - before)
            self.last[observation.episode_id] = now
        return [Action.LEFT] * len(observations)

    def reset(self) -> None:
        """Discard all measurements so far."""
        super().reset()
        self.last: dict[str, float] = {}
        self.longest: dict[str, float] = {}


def drain_worker(server: Server) -> None:
    """Send SIGTERM to one of two workers."""
    os.kill(family(server.process.pid)[1], signal.SIGTERM)


def kill_worker(server: Server) -> None:
    """Kill one of two workers."""
    os.kill(family(server.process.pid)[1], signal.SIGKILL)


def restart_server(server: Server) -> None:
    """Kill the only process, and start another on its port."""
    server.kill()
    server.start()


ROWS: dict[str, tuple[int, Callable[[Server], None]]] = {
    "one of two workers drains": (2, drain_worker),
    "one of two workers is killed": (2, kill_worker),
    "the only process is killed, and restarted": (1, restart_server),
}


def measure(data: Path, split: str, language: str, parallel: int, row: str) -> tuple[float, float]:
    """Measure one round: the longest wait of an episode for its next observation, without and with the fault."""
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
        agent = TurningAgent()
        agent.reset()
        settings = Settings(min(parallel, run.episodes), types_pb2.ENCODING_RAW)
        playing = threading.Thread(target=play_streams, args=(there, run, agent, settings), daemon=True)
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


def wait_for_all(agent: TurningAgent, episodes: Iterable[str], fault: float) -> None:
    """Wait until each of these has had an observation at least a second after the fault."""
    while left := [episode for episode in episodes if agent.last[episode] < fault + 1.0]:
        if time.perf_counter() > fault + PATIENCE:
            raise SystemExit(f"{len(left)} episodes had no observation for {PATIENCE:.0f} seconds")
        time.sleep(0.05)


def main() -> None:
    """Run the benchmark and print its table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--data", type=Path, help="data folder (default: the sample episodes)")
    parser.add_argument("--rounds", type=int, default=5, help="number of rounds (default: %(default)s)")
    parser.add_argument("--parallel", type=int, default=16, help="episodes open at once (default: %(default)s)")
    parser.add_argument("--json", type=Path, help="output file for the results")
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
