"""Load for the server under measurement: a random walk that measures its waits, in runs that are ended early."""

import statistics
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace

from arramon.v1 import evaluation_pb2
from arramon_agents.random_walk import Agent as RandomWalk
from arramon_client.agent import Episode, Observation
from arramon_client.multi_stream import play_streams
from arramon_client.play import Settings, play
from arramon_client.transport.connection import METADATA, Server
from arramon_server.episodes.splits import Split
from benchmarks.serving.server import SENSORS

SECTIONS = 64
"""Maximum number of episodes opened to build all sections."""

WARM_UP_SECONDS = 1.0

LONGEST_WAIT_SECONDS = 60.0
"""Time after which a measurement without a step is given up."""


@dataclass
class TimedRandomWalk:
    """A random walk that measures the waits between its actions and their observations.

    Attributes:
        steps: number of its actions.
        waits: seconds from each action to the next observation of its episode.
    """

    steps: int = 0
    waits: list[float] = field(default_factory=list)
    _agent: RandomWalk = field(default_factory=RandomWalk)
    _answered: dict[str, float] = field(default_factory=dict)
    _lock: threading.Lock = field(default_factory=threading.Lock)

    def begin(self, episode: Episode) -> None:
        """Begin an episode of the random walk."""
        self._agent.begin(episode)

    def end(self, episode_id: str) -> None:
        """Discard the time of the episode's last action."""
        with self._lock:
            self._answered.pop(episode_id, None)

    def act(self, observations: Sequence[Observation]) -> Sequence[int]:
        """Return the random walk's actions, and record the waits."""
        now = time.perf_counter()
        with self._lock:
            for observation in observations:
                before = self._answered.get(observation.episode_id)
                if before is not None:
                    self.waits.append(now - before)
        actions = self._agent.act(observations)
        with self._lock:
            self.steps += len(observations)
            self._answered.update((o.episode_id, time.perf_counter()) for o in observations)
        return actions

    def reset(self) -> None:
        """Discard all measurements so far, those of the warm-up."""
        with self._lock:
            self.steps, self.waits = 0, []


@dataclass(frozen=True)
class PlayRate:
    """Speed and latency of play.

    Attributes:
        rate: steps per second.
        mean, p50, p99: milliseconds from an action to the next observation of its episode.
        steps: number of steps.
    """

    rate: float
    mean: float
    p50: float
    p99: float
    steps: int


def measure_play(agent: TimedRandomWalk, seconds: float) -> PlayRate:
    """Measure the speed of an agent's play for some seconds.

    Raises:
        SystemExit: if it plays no step for a minute, as when all episodes of its run have ended.
    """
    agent.reset()
    started = time.perf_counter()
    time.sleep(seconds)
    steps, waits, elapsed = agent.steps, sorted(agent.waits), time.perf_counter() - started
    while not waits:  # In a short time on a busy machine there may be none.
        if elapsed > seconds + LONGEST_WAIT_SECONDS:
            sys.exit("no step was played for a minute: the run has too few episodes; give more with --data")
        time.sleep(0.05)
        steps, waits, elapsed = agent.steps, sorted(agent.waits), time.perf_counter() - started
    return PlayRate(steps / elapsed, 1e3 * statistics.fmean(waits), *percentiles(waits), steps)


def percentiles(waits: Sequence[float]) -> tuple[float, float]:
    """Return the median and the 99th percentile of sorted waits, in milliseconds."""
    return 1e3 * waits[len(waits) // 2], 1e3 * waits[len(waits) * 99 // 100]


def run_request(split: Split, sensors: Sequence[str] = SENSORS) -> evaluation_pb2.CreateRunRequest:
    """Return the request of a run on a split, in the first of its languages."""
    return evaluation_pb2.CreateRunRequest(
        agent="benchmark", split=split.name, language=min(split.languages), sensors=sensors
    )


@contextmanager
def background_play(
    server: Server,
    request: evaluation_pb2.CreateRunRequest,
    agent: TimedRandomWalk,
    settings: Settings,
    *,
    streams: int = 1,
    warm_up: float = WARM_UP_SECONDS,
) -> Iterator[evaluation_pb2.Run]:
    """Play a run in background threads, yielding after a warm-up; the run is cancelled at the end.

    Args:
        server: the server.
        request: request for the run.
        agent: the agent.
        settings: settings of each stream; at most as many episodes as the run has are opened.
        streams: number of streams, each with its own client.
        warm_up: seconds of play after every open episode has had an observation, at most 1.

    Raises:
        SystemExit: if all episodes end too early.
    """
    run = server.stub.CreateRun(request, metadata=METADATA)
    settings = replace(settings, parallel=min(settings.parallel, run.episodes))
    threads = [
        threading.Thread(target=play_streams, args=(server, run, agent, settings), daemon=True)
        if streams == 1
        else threading.Thread(target=play, args=(server.stub, run, agent, settings), daemon=True)
        for _ in range(streams)
    ]
    for thread in threads:
        thread.start()
    while agent.steps < min(streams * settings.parallel, run.episodes) and _are_playing(threads):
        time.sleep(0.05)
    time.sleep(min(warm_up, WARM_UP_SECONDS))
    yield run
    if not _are_playing(threads):
        sys.exit(f"{run.split} has too few episodes: all were played within the round; give more with --data")
    server.stub.CancelRun(evaluation_pb2.CancelRunRequest(run_id=run.run_id), metadata=METADATA)
    for thread in threads:
        thread.join()


def _are_playing(threads: Sequence[threading.Thread]) -> bool:
    return any(thread.is_alive() for thread in threads)


def build_all_sections(
    server: Server, request: evaluation_pb2.CreateRunRequest, warm_up: float = WARM_UP_SECONDS
) -> None:
    """Open enough episodes to build every section, so that this does not count as part of a step."""
    fewer = with_fewer_episodes(server, request, SECTIONS)
    with background_play(server, fewer, TimedRandomWalk(), Settings(SECTIONS), warm_up=warm_up):
        pass


def with_fewer_episodes(
    server: Server, request: evaluation_pb2.CreateRunRequest, episodes: int
) -> evaluation_pb2.CreateRunRequest:
    """Return the request for at most a number of episodes of its split: fewer are left to cancel at the end."""
    there = next(split.episodes[request.language] for split in server.info.splits if split.name == request.split)
    fewer = evaluation_pb2.CreateRunRequest()
    fewer.CopyFrom(request)
    fewer.episodes = episodes if episodes < there else 0
    return fewer
