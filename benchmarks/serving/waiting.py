"""Steps per second of agents that wait, such as for a model behind an API, whose calls take unequal times.

    python -m benchmarks.serving.waiting [--data DIR] [--seconds 20] [--rounds 2] [--call 0.1] [--slow-call 3]
        [--json FILE]

Each call takes `--call` seconds, one in twenty takes `--slow-call`. Eight episodes are played in three ways, in turn:

- "free-running": a process for each episode, with a loop of its own; nothing waits for anything else;
- "async agent": one client, an agent whose `act` is a coroutine function;
- "batch agent": one client, an agent that makes the calls of a batch at once, and returns when all have answered.
"""

import asyncio
import multiprocessing
import statistics
import threading
import time
import zlib
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing.sharedctypes import Synchronized
from pathlib import Path

from arramon.v1 import evaluation_pb2
from arramon_agents.random_walk import Agent as RandomWalk
from arramon_client.agent import Episode, Observation
from arramon_client.errors import ArramonClientError
from arramon_client.play import Settings, play
from arramon_client.transport.connection import METADATA, Server, connect
from benchmarks.common import (
    add_data,
    add_json,
    add_rounds,
    add_seconds,
    data_or_sample,
    largest_split,
    parser_of,
    positive_float,
    text_table,
    write_json,
)
from benchmarks.serving.play import run_request, with_fewer_episodes
from benchmarks.serving.server import ServerSetting, running_server

EPISODES = 8
ONE_IN = 20
"""One call in this many is slow, at the same steps in every way of playing."""

WAYS = ("free-running", "async agent", "batch agent")


@dataclass(frozen=True)
class Delays:
    """Duration of the calls, in seconds."""

    call: float
    slow_call: float

    def of(self, observation: Observation) -> float:
        """Return how long the call for an observation takes."""
        shift = zlib.crc32(observation.episode_id.encode())
        return self.slow_call if (observation.step + shift) % ONE_IN == 0 else self.call


class Counter:
    """Counter of steps, shared by processes."""

    def __init__(self) -> None:
        self.steps: Synchronized[int] = multiprocessing.get_context("spawn").Value("q", 0)
        self.begun: Synchronized[int] = multiprocessing.get_context("spawn").Value("q", 0)


class BatchAgent:
    """A random walk whose calls for a batch are made at once."""

    def __init__(self, delays: Delays, counter: Counter) -> None:
        self._delays, self._counter, self._walk = delays, counter, RandomWalk()

    def begin(self, episode: Episode) -> None:
        """Count the episode."""
        self._walk.begin(episode)
        with self._counter.begun.get_lock():
            self._counter.begun.value += 1

    def act(self, observations: Sequence[Observation]) -> list[int]:
        """Wait for the slowest call, and return the actions."""
        time.sleep(max(map(self._delays.of, observations)))
        return self.count(observations)

    def count(self, observations: Sequence[Observation]) -> list[int]:
        """Count steps, and return their actions."""
        with self._counter.steps.get_lock():
            self._counter.steps.value += len(observations)
        return list(self._walk.act(observations))


class AsyncAgent(BatchAgent):
    """The same agent with a call for each observation."""

    async def act(self, observation: Observation) -> int:  # type: ignore[override]  # another contract
        """Wait for the call, and return the action."""
        await asyncio.sleep(self._delays.of(observation))
        return self.count([observation])[0]


def free_running(address: str, run: bytes, delays: Delays, counter: Counter) -> None:
    """Play one episode of a run at a time, as the only work of a process."""
    with connect(address) as server:
        play(
            server.stub,
            evaluation_pb2.Run.FromString(run),
            BatchAgent(delays, counter),
            Settings(parallel=1),
            address=address,
        )


@contextmanager
def playing(way: str, server: Server, run: evaluation_pb2.Run, delays: Delays, counter: Counter) -> Iterator[None]:
    """Play a run in one of the ways until the end of the context, in which the run must be cancelled."""
    if way == "free-running":
        context = multiprocessing.get_context("spawn")
        arguments = (server.address, run.SerializeToString(), delays, counter)
        loops = [context.Process(target=free_running, args=arguments, daemon=True) for _ in range(EPISODES)]
        with _started(loops):
            yield
        return
    agent = (AsyncAgent if way == "async agent" else BatchAgent)(delays, counter)
    settings = Settings(parallel=EPISODES)
    with _started([threading.Thread(target=_quietly(play), args=(server.stub, run, agent, settings), daemon=True)]):
        yield


@contextmanager
def _started(workers: Sequence[threading.Thread | multiprocessing.process.BaseProcess]) -> Iterator[None]:
    for worker in workers:
        worker.start()
    yield
    for worker in workers:
        worker.join()


def _quietly(function: Callable[..., object]) -> Callable[..., None]:
    """Return a function that ends without a traceback when the run is cancelled under it."""

    def call(*arguments: object) -> None:
        try:
            function(*arguments)
        except ArramonClientError as error:
            print(f"ended: {error}")

    return call


def measure(data: Path, way: str, delays: Delays, seconds: float) -> float:
    """Return the steps per second of one way of playing."""
    split, counter = largest_split(data), Counter()
    with running_server(data, ServerSetting(way)) as process, connect(process.address) as server:
        run = server.stub.CreateRun(with_fewer_episodes(server, run_request(split), 4 * EPISODES), metadata=METADATA)
        with playing(way, server, run, delays, counter):
            while counter.begun.value < min(EPISODES, run.episodes):
                time.sleep(0.05)
            time.sleep(1.0)  # The first steps build the sections.
            before, started = counter.steps.value, time.perf_counter()
            time.sleep(seconds)
            rate = (counter.steps.value - before) / (time.perf_counter() - started)
            server.stub.CancelRun(evaluation_pb2.CancelRunRequest(run_id=run.run_id), metadata=METADATA)
    return rate


def main() -> None:
    """Run the benchmark and print its table."""
    parser = parser_of(__doc__)
    add_data(parser)
    add_seconds(parser, 20.0, "duration of each measurement")
    add_rounds(parser, 2)
    parser.add_argument(
        "--call", type=positive_float, default=0.1, metavar="S", help="seconds of a call (default: 0.1)"
    )
    parser.add_argument(
        "--slow-call", type=positive_float, default=3.0, metavar="S", help="seconds of one call in twenty (default: 3)"
    )
    add_json(parser)
    options = parser.parse_args()
    delays = Delays(options.call, options.slow_call)
    rounds: dict[str, list[float]] = {way: [] for way in WAYS}
    with data_or_sample(options.data) as data:
        for _ in range(options.rounds):
            for way in WAYS:
                rounds[way].append(measure(data, way, delays, options.seconds))
    medians = {way: statistics.median(found) for way, found in rounds.items()}
    ideal = EPISODES * ONE_IN / ((ONE_IN - 1) * delays.call + delays.slow_call)
    rows = [(way, f"{rate:.1f}", f"{rate / medians['free-running']:.2f}") for way, rate in medians.items()]
    print(text_table(("", "steps/s", "ratio"), [*rows, ("without any other cost", f"{ideal:.1f}", "")]))
    write_json(options.json, {"seconds": options.seconds, "delays": vars(delays), "rounds": rounds})


if __name__ == "__main__":
    main()
