"""Interruption of episodes, in seconds, when a server process ends and others or its successor continue.

    python -m benchmarks.serving.pauses [--data DIR] [--rounds 5] [--parallel 16] [--seconds 3] [--json FILE]

A real client plays over TCP. In each round a server process is stopped or killed: one of two workers, or the only
process, which is restarted at once. The rows show the waits of the episodes that were open then, and the longest wait
of any of them without a disturbance.
"""

import os
import signal
import time
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from statistics import median

from arramon.v1 import types_pb2
from arramon_client.agent import Action, Observation
from arramon_client.play import Settings
from arramon_client.transport.connection import connect
from arramon_server.episodes.splits import Split
from benchmarks.common import (
    add_data,
    add_json,
    add_rounds,
    add_seconds,
    data_or_sample,
    largest_split,
    parser_of,
    positive_int,
    text_table,
    write_json,
)
from benchmarks.serving.play import TimedRandomWalk, background_play, run_request
from benchmarks.serving.server import MeasuredServer, ServerSetting, running_server

PATIENCE = 60.0
"""Seconds without an observation after which the benchmark fails."""


STEP_LIMIT = 10_000
"""Step limit of a phase: the agent only turns, and its episodes must still be open after the fault."""


class TurningAgent(TimedRandomWalk):
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


def drain_worker(server: MeasuredServer) -> None:
    """Send SIGTERM to one of two workers."""
    os.kill(server.process_ids[1], signal.SIGTERM)


def kill_worker(server: MeasuredServer) -> None:
    """Kill one of two workers."""
    os.kill(server.process_ids[1], signal.SIGKILL)


def restart_server(server: MeasuredServer) -> None:
    """Kill the only process, and start another on its port."""
    server.kill()
    server.start()


ROWS: dict[str, tuple[int, Callable[[MeasuredServer], None]]] = {
    "one of two workers drains": (2, drain_worker),
    "one of two workers is killed": (2, kill_worker),
    "the only process is killed, and restarted": (1, restart_server),
}


def measure(data: Path, split: Split, parallel: int, seconds: float, row: str) -> tuple[float, float]:
    """Measure one round: the longest wait of an episode for its next observation, without and with the fault."""
    workers, fault = ROWS[row]
    setting = ServerSetting(row, tcp=True, workers=workers, steps=STEP_LIMIT)
    with running_server(data, setting) as process, connect(process.address) as server:
        agent = TurningAgent()
        agent.reset()
        with background_play(
            server, run_request(split), agent, Settings(parallel, types_pb2.ENCODING_RAW), warm_up=seconds
        ):
            agent.reset()
            time.sleep(seconds)
            quiet, open_then = max(agent.longest.values()), dict(agent.last)
            agent.longest, moment = {}, time.perf_counter()
            fault(process)
            wait_for_all(agent, open_then, moment)
            longest = max(agent.longest[episode] for episode in open_then)
    return quiet, longest


def wait_for_all(agent: TurningAgent, episodes: Iterable[str], fault: float) -> None:
    """Wait until each of these has had an observation at least a second after the fault."""
    while left := [episode for episode in episodes if agent.last[episode] < fault + 1.0]:
        if time.perf_counter() > fault + PATIENCE:
            raise SystemExit(f"{len(left)} episodes had no observation for {PATIENCE:.0f} seconds")
        time.sleep(0.05)


def main() -> None:
    """Run the benchmark and print its table."""
    parser = parser_of(__doc__)
    add_data(parser)
    add_rounds(parser, 5)
    parser.add_argument(
        "--parallel", type=positive_int, default=16, help="episodes open at once (default: %(default)s)"
    )
    add_seconds(parser, 3.0, "undisturbed play of each round")
    add_json(parser)
    options = parser.parse_args()
    with data_or_sample(options.data) as data:
        split = largest_split(data)
        found: dict[str, list[tuple[float, float]]] = {row: [] for row in ROWS}
        for _ in range(options.rounds):
            for row in ROWS:
                found[row].append(measure(data, split, options.parallel, options.seconds, row))
    lines = []
    for row, pairs in found.items():
        quiet, longest = zip(*pairs, strict=True)
        lines.append((row, f"{median(quiet):.3f}", f"{median(longest):.2f}", f"{max(longest):.2f}"))
    print(text_table(("longest wait of an episode, seconds", "quiet", "median", "max"), lines))
    write_json(options.json, found)


if __name__ == "__main__":
    main()
