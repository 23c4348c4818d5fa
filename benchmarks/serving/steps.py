"""Steps per second, end to end: a real server, a real client and a random walk on this machine.

    python -m benchmarks.serving.steps [--data DIR] [--seconds 6] [--rounds 3] [--postgres URL] [--json FILE]

Every row starts its own server process and plays for some seconds with the client's own play loop. The rows alternate,
round by round, so that changes of the machine's speed affect all of them; the table shows medians. The first row is the
baseline of the ratios: one core in process, rules and frames of the same random walk alone, without gRPC, journal or
client.
"""

import argparse
import json
import os
import re
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import cycle
from pathlib import Path

from arramon.v1 import evaluation_pb2, types_pb2
from arramon_agents.random_walk import Agent as RandomWalk
from arramon_client.agent import Episode, Observation
from arramon_client.multi_stream import play_streams
from arramon_client.play import Settings
from arramon_client.transport.connection import METADATA, Server, connect
from arramon_server.episodes.splits import Split, read_splits
from arramon_server.runs.play.session import Session
from arramon_server.runs.play.worlds import Worlds
from arramon_server.sim.rules import Action, Limits
from benchmarks.common import data_or_sample

SENSORS = ("rgb", "depth")


@dataclass(frozen=True)
class Setting:
    """Settings of one row of the table."""

    name: str
    parallel: int = 16
    size: int = 224
    encoding: types_pb2.Encoding.ValueType = types_pb2.ENCODING_SHARED
    tcp: bool = False
    workers: int = 1
    sensors: tuple[str, ...] = SENSORS
    fsync: bool = False
    postgres: bool = False
    program: tuple[str, ...] = ("-m", "arramon_server")


SETTINGS = (
    Setting("1 episode", parallel=1),
    Setting("16 episodes"),
    Setting("128 episodes", parallel=128),
    Setting("1000 episodes", parallel=1000),
    Setting("1, fsync", parallel=1, fsync=True),
    Setting("16, fsync", fsync=True),
    Setting("1, raw", parallel=1, encoding=types_pb2.ENCODING_RAW),
    Setting("16, raw", encoding=types_pb2.ENCODING_RAW),
    Setting("128, raw", parallel=128, encoding=types_pb2.ENCODING_RAW),
    Setting("16, over TCP", tcp=True, encoding=types_pb2.ENCODING_RAW),
    Setting("16, lossless", encoding=types_pb2.ENCODING_ZSTD),
    Setting("16, JPEG", encoding=types_pb2.ENCODING_JPEG),
    Setting("16, lossless, over TCP", tcp=True, encoding=types_pb2.ENCODING_ZSTD),
    Setting("16, JPEG, over TCP", tcp=True, encoding=types_pb2.ENCODING_JPEG),
    Setting("16, 128x128", size=128),
    Setting("16, 128x128, JPEG", size=128, encoding=types_pb2.ENCODING_JPEG),
    Setting("16, 2 workers", workers=2),
    Setting("128, 2 workers", parallel=128, workers=2),
    Setting("16, no images", sensors=()),
    Setting("1, PostgreSQL", parallel=1, postgres=True),
    Setting("16, PostgreSQL", postgres=True),
    Setting("128, PostgreSQL", parallel=128, postgres=True),
)


@dataclass
class Timed:
    """A random walk that measures the waits between its actions and their observations."""

    steps: int = 0
    waits: list[float] = field(default_factory=list)
    _agent: RandomWalk = field(default_factory=RandomWalk)
    _answered: dict[str, float] = field(default_factory=dict)
    _lock: threading.Lock = field(default_factory=threading.Lock)

    def begin(self, episode: Episode) -> None:
        """Begin an episode of the random walk."""
        self._agent.begin(episode)

    def end(self, episode_id: str) -> None:
        """Discard when the episode's last action was taken."""
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
class Measured:
    """Results of one round of a row.

    Attributes:
        rate: steps per second.
        mean, p50, p99: milliseconds from an action to the next observation of its episode.
        memory: resident memory of the server's processes, in MB.
        work: CPU time of the server's processes per step, in milliseconds; in process, of this one.
        own: CPU time of the client per step, in milliseconds.
        ready: seconds until the server listens.
    """

    rate: float
    mean: float = 0.0
    p50: float = 0.0
    p99: float = 0.0
    memory: float = 0.0
    ready: float = 0.0
    work: float = 0.0
    own: float = 0.0


def in_process(split: Split, seconds: float, size: int = 224) -> Measured:
    """Measure rules and frames of 16 episodes in turn, in this process: what the served rows draw, and nothing else.

    The episodes come in the order of a run, and the same agent plays them: how long a frame takes depends on what is
    seen. An agent that always walks against the same wall sees little, and is drawn in half the time.
    """
    worlds, limits, agent = Worlds({split.name: split}), Limits(), RandomWalk()
    waiting = cycle(split.in_playing_order(next(iter(split.languages))))

    def begin() -> Session:
        episode = next(waiting)
        return Session(episode, worlds.ground(split.name, episode), limits)

    for section in {episode.section: episode for episode in split.episodes.values()}.values():
        worlds.render(split.name, section, Session(section, worlds.ground(split.name, section), limits).state, size)
    sessions = [begin() for _ in range(16)]
    steps, started, worked = 0, time.perf_counter(), time.process_time()
    while time.perf_counter() - started < seconds:
        for number, session in enumerate(sessions):
            session.apply(Action(agent.draw(session.episode.episode_id, session.state.step)))
            if session.state.finished:
                session = sessions[number] = begin()
            worlds.render(split.name, session.episode, session.state, size)
            steps += 1
    work = time.process_time() - worked
    rate = steps / (time.perf_counter() - started)
    worlds.close()
    return Measured(rate, work=1e3 * work / steps)


@contextmanager
def serving(
    data: Path, setting: Setting, environment: Mapping[str, str] | None = None, *, journal: str = ""
) -> Iterator[tuple[str, "subprocess.Popen[str]", float]]:
    """Run a server, with its own journal unless a URL is given; yields address, process and startup seconds."""
    with tempfile.TemporaryDirectory() as folder:
        listen = "127.0.0.1:0" if setting.tcp else f"unix:{folder}/socket"
        command = [sys.executable, *setting.program, "serve", "--data", str(data), "--listen", listen]
        command += ["--journal", journal or f"sqlite:///{folder}/journal.db", "--workers", str(setting.workers)]
        command += ["--fsync" if setting.fsync else "--no-fsync"]
        started = time.perf_counter()
        around = {**os.environ, **(environment or {})}
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=around) as process:
            try:
                assert process.stdout is not None
                address = next(line.split()[-1] for line in process.stdout if line.startswith("listening on "))
                yield address, process, time.perf_counter() - started
            finally:
                process.terminate()


def measure(data: Path, split: Split, setting: Setting, seconds: float, postgres: str = "") -> Measured:
    """Measure one round: warm up, then play for some seconds."""
    with (
        serving(data, setting, journal=postgres if setting.postgres else "") as (address, process, ready),
        connect(address) as server,
    ):
        language = next(iter(split.languages))
        request = evaluation_pb2.CreateRunRequest(agent="benchmark", split=split.name, language=language)
        request.sensors.extend(setting.sensors)
        see_all_sections(server, request)
        run = server.stub.CreateRun(request, metadata=METADATA)
        agent = Timed()
        settings = Settings(min(setting.parallel, run.episodes), setting.encoding, image_size=setting.size)
        playing = threading.Thread(target=play_streams, args=(server, run, agent, settings), daemon=True)
        playing.start()
        warm_up(agent, settings.parallel)
        agent.reset()
        started, before = time.perf_counter(), sum(cpu_seconds(pid) for pid in family(process.pid))
        own = time.process_time()
        time.sleep(seconds)
        steps, waits, elapsed = agent.steps, sorted(agent.waits), time.perf_counter() - started
        own = time.process_time() - own
        work = sum(cpu_seconds(pid) for pid in family(process.pid)) - before
        memory = sum(resident(pid) for pid in family(process.pid))
        if not playing.is_alive():
            sys.exit(f"{split.name} has too few episodes: all were played within the round; give more with --data")
        server.stub.CancelRun(evaluation_pb2.CancelRunRequest(run_id=run.run_id), metadata=METADATA)
        playing.join()
    return Measured(
        rate=steps / elapsed,
        mean=1e3 * statistics.fmean(waits),
        p50=1e3 * waits[len(waits) // 2],
        p99=1e3 * waits[len(waits) * 99 // 100],
        memory=memory,
        ready=ready,
        work=1e3 * work / steps,
        own=1e3 * own / steps,
    )


def see_all_sections(server: Server, request: evaluation_pb2.CreateRunRequest) -> None:
    """Open enough episodes to build every section, as that happens once and is not part of a step."""
    run = server.stub.CreateRun(some(server, request, 64), metadata=METADATA)
    agent, settings = Timed(), Settings(min(64, run.episodes))
    playing = threading.Thread(target=play_streams, args=(server, run, agent, settings), daemon=True)
    playing.start()
    warm_up(agent, settings.parallel)
    server.stub.CancelRun(evaluation_pb2.CancelRunRequest(run_id=run.run_id), metadata=METADATA)
    playing.join()


def some(server: Server, request: evaluation_pb2.CreateRunRequest, episodes: int) -> evaluation_pb2.CreateRunRequest:
    """Return the request limited to so many episodes, as unplayed episodes must be cancelled later."""
    there = next(split.episodes[request.language] for split in server.info.splits if split.name == request.split)
    fewer = evaluation_pb2.CreateRunRequest()
    fewer.CopyFrom(request)
    fewer.episodes = episodes if episodes < there else 0
    return fewer


def warm_up(agent: Timed, parallel: int) -> None:
    """Wait until every open episode has had an observation, and a second more."""
    while agent.steps < parallel:
        time.sleep(0.05)
    time.sleep(1.0)


def family(process_id: int) -> list[int]:
    """Return the ids of a process and its children; Linux only."""
    children = Path(f"/proc/{process_id}/task/{process_id}/children").read_text().split()
    return [process_id, *(int(child) for child in children)]


def resident(process_id: int) -> float:
    """Return the resident memory of a process, including shared memory, in MB."""
    for line in Path(f"/proc/{process_id}/status").read_text().splitlines():
        if line.startswith("VmRSS:"):
            return int(line.split()[1]) / 1000
    return 0.0


def cpu_seconds(process_id: int) -> float:
    """Return the CPU seconds that a process has used so far."""
    fields = Path(f"/proc/{process_id}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def median(rounds: Sequence[Measured]) -> Measured:
    """Return the medians by field."""
    return Measured(**{name: statistics.median(getattr(r, name) for r in rounds) for name in Measured.__annotations__})


def main() -> None:
    """Run the benchmark and print its table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--data", type=Path, help="data folder (default: the few sample episodes)")
    parser.add_argument("--seconds", type=float, default=6.0, help="duration of each round (default: %(default)s)")
    parser.add_argument("--rounds", type=int, default=3, help="number of rounds (default: %(default)s)")
    parser.add_argument("--only", default="", help="only rows whose name matches this regular expression")
    parser.add_argument("--postgres", default="", help="URL of an empty database, for the rows with PostgreSQL")
    parser.add_argument("--json", type=Path, help="output file for the results")
    options = parser.parse_args()
    with data_or_sample(options.data) as data:
        split = max(read_splits(data).values(), key=lambda split: len(split.episodes))
        chosen = [
            setting
            for setting in SETTINGS
            if re.search(options.only, setting.name) and (options.postgres or not setting.postgres)
        ]
        rounds: dict[str, list[Measured]] = {"in process": [], **{setting.name: [] for setting in chosen}}
        for _ in range(options.rounds):
            rounds["in process"].append(in_process(split, options.seconds))
            for setting in chosen:
                rounds[setting.name].append(measure(data, split, setting, options.seconds, options.postgres))
    show({name: median(measured) for name, measured in rounds.items()}, split)
    if options.json:
        figures = {name: [vars(each) for each in measured] for name, measured in rounds.items()}
        options.json.write_text(json.dumps({"split": split.name, "rounds": figures}, indent=1))


def show(rows: dict[str, Measured], split: Split) -> None:
    """Print the table."""
    base = rows["in process"].rate
    print(f"split {split.name}, {len(split.episodes)} episodes. Defaults: 224, shared memory, Unix socket, no fsync")
    print(
        f"{'':20} {'steps/s':>8} {'ratio':>6} {'mean ms':>8} {'p50 ms':>8} {'p99 ms':>8} {'MB':>6} {'CPU ms':>7} "
        f"{'client':>7} {'start s':>8}"
    )
    for name, row in rows.items():
        print(
            f"{name:20} {row.rate:8.0f} {row.rate / base:6.2f} {row.mean:8.1f} {row.p50:8.1f} {row.p99:8.1f} "
            f"{row.memory:6.0f} {row.work:7.2f} {row.own:7.2f} {row.ready:8.1f}"
        )


if __name__ == "__main__":
    main()
