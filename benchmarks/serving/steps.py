"""Steps per second, end to end: a real server, a real client and a random walk on this machine.

    python -m benchmarks.serving.steps [--data DIR] [--seconds 6] [--rounds 3] [--postgres URL] [--json FILE]

Every row starts its own server process and plays for some seconds with the client's own play loop. The rows alternate,
round by round, so that changes of the machine's speed affect all of them; the table shows medians. The first row is the
baseline of the ratios: one core in process, rules and frames of the same random walk alone, without gRPC, journal or
client.
"""

import re
import statistics
import time
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import cycle
from pathlib import Path

from arramon.v1 import types_pb2
from arramon_agents.random_walk import Agent as RandomWalk
from arramon_client.play import Settings
from arramon_client.transport.connection import connect
from arramon_client.world import Action
from arramon_server.episodes.splits import Split
from arramon_server.runs.play.session import EpisodeSession
from arramon_server.runs.play.worlds import Worlds
from arramon_server.sim.rules import Limits
from benchmarks.common import (
    add_data,
    add_json,
    add_rounds,
    add_seconds,
    data_or_sample,
    largest_split,
    parser_of,
    text_table,
    write_json,
)
from benchmarks.serving.play import TimedRandomWalk, background_play, build_all_sections, measure_play, run_request
from benchmarks.serving.server import ServerSetting, running_server

SETTINGS = (
    ServerSetting("1 episode", parallel=1),
    ServerSetting("16 episodes"),
    ServerSetting("128 episodes", parallel=128),
    ServerSetting("1000 episodes", parallel=1000),
    ServerSetting("1, fsync", parallel=1, fsync=True),
    ServerSetting("16, fsync", fsync=True),
    ServerSetting("1, raw", parallel=1, encoding=types_pb2.ENCODING_RAW),
    ServerSetting("16, raw", encoding=types_pb2.ENCODING_RAW),
    ServerSetting("128, raw", parallel=128, encoding=types_pb2.ENCODING_RAW),
    ServerSetting("16, over TCP", tcp=True, encoding=types_pb2.ENCODING_RAW),
    ServerSetting("16, lossless", encoding=types_pb2.ENCODING_ZSTD),
    ServerSetting("16, JPEG", encoding=types_pb2.ENCODING_JPEG),
    ServerSetting("16, lossless, over TCP", tcp=True, encoding=types_pb2.ENCODING_ZSTD),
    ServerSetting("16, JPEG, over TCP", tcp=True, encoding=types_pb2.ENCODING_JPEG),
    ServerSetting("16, 128x128", size=128),
    ServerSetting("16, 128x128, JPEG", size=128, encoding=types_pb2.ENCODING_JPEG),
    ServerSetting("16, 2 workers", workers=2),
    ServerSetting("128, 2 workers", parallel=128, workers=2),
    ServerSetting("16, no images", sensors=()),
    ServerSetting("1, PostgreSQL", parallel=1, postgres=True),
    ServerSetting("16, PostgreSQL", postgres=True),
    ServerSetting("128, PostgreSQL", parallel=128, postgres=True),
)


@dataclass(frozen=True)
class StepFigures:
    """Results of one round of a row.

    Attributes:
        rate: steps per second.
        mean, p50, p99: milliseconds from an action to the next observation of its episode.
        memory: resident memory of the server's processes, in MB.
        work: CPU time of the server's processes per step, in milliseconds; for the in-process row, of this process.
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


def in_process(split: Split, seconds: float, size: int = 224) -> StepFigures:
    """Measure rules and frames of 16 episodes in turn, in this process: the same frames as in the served rows.

    The same agent plays the episodes in the order of a run, as the time of a frame depends on what is visible: for an
    agent that walks against a wall, rendering takes half the time.
    """
    worlds, limits, agent = Worlds({split.name: split}), Limits(), RandomWalk()
    waiting = cycle(split.in_playing_order(next(iter(split.languages))))

    def begin() -> EpisodeSession:
        episode = next(waiting)
        return EpisodeSession(episode, worlds.world(split.name, episode), limits)

    for section in {episode.section: episode for episode in split.episodes.values()}.values():
        for _ in worlds.load(split.name, section, drawn=True):
            pass
    sessions = [begin() for _ in range(16)]
    steps, started, worked = 0, time.perf_counter(), time.process_time()
    while time.perf_counter() - started < seconds:
        for number, session in enumerate(sessions):
            session.apply(Action(agent.draw(session.episode.episode_id, session.state.step)))
            if session.state.finished:
                session = sessions[number] = begin()
            worlds.world(split.name, session.episode).render(session.state, size)
            steps += 1
    work = time.process_time() - worked
    rate = steps / (time.perf_counter() - started)
    worlds.close()
    return StepFigures(rate, work=1e3 * work / steps)


def measure(data: Path, split: Split, setting: ServerSetting, seconds: float, postgres: str = "") -> StepFigures:
    """Measure one round: warm up, then play for some seconds."""
    with (
        running_server(data, setting, journal=postgres if setting.postgres else "") as process,
        connect(process.address) as server,
    ):
        request, agent = run_request(split, setting.sensors), TimedRandomWalk()
        build_all_sections(server, request, seconds)
        settings = Settings(setting.parallel, setting.encoding, image_size=setting.size)
        with background_play(server, request, agent, settings, warm_up=seconds):
            before, own = process.cpu_seconds, time.process_time()
            found = measure_play(agent, seconds)
            own, work = time.process_time() - own, process.cpu_seconds - before
            memory = process.memory
    return StepFigures(
        rate=found.rate,
        mean=found.mean,
        p50=found.p50,
        p99=found.p99,
        memory=memory,
        ready=process.ready,
        work=1e3 * work / found.steps,
        own=1e3 * own / found.steps,
    )


def median(rounds: Sequence[StepFigures]) -> StepFigures:
    """Return the medians by field."""
    return StepFigures(
        **{name: statistics.median(getattr(r, name) for r in rounds) for name in StepFigures.__annotations__}
    )


def main() -> None:
    """Run the benchmark and print its table."""
    parser = parser_of(__doc__)
    add_data(parser)
    add_seconds(parser, 6.0, "duration of each round")
    add_rounds(parser, 3)
    parser.add_argument("--only", default="", help="only rows whose name matches this regular expression")
    parser.add_argument("--postgres", default="", help="URL of an empty database, for the rows with PostgreSQL")
    add_json(parser)
    options = parser.parse_args()
    with data_or_sample(options.data) as data:
        split = largest_split(data)
        chosen = [
            setting
            for setting in SETTINGS
            if re.search(options.only, setting.name) and (options.postgres or not setting.postgres)
        ]
        rounds: dict[str, list[StepFigures]] = {"in process": [], **{setting.name: [] for setting in chosen}}
        for _ in range(options.rounds):
            rounds["in process"].append(in_process(split, options.seconds))
            for setting in chosen:
                rounds[setting.name].append(measure(data, split, setting, options.seconds, options.postgres))
    print(f"split {split.name}, {len(split.episodes)} episodes. Defaults: 224, shared memory, Unix socket, no fsync")
    print(table({name: median(measured) for name, measured in rounds.items()}))
    figures = {name: [vars(each) for each in measured] for name, measured in rounds.items()}
    write_json(options.json, {"split": split.name, "rounds": figures})


def table(rows: dict[str, StepFigures]) -> str:
    """Return the table."""
    base = rows["in process"].rate
    header = ("", "steps/s", "ratio", "mean ms", "p50 ms", "p99 ms", "MB", "CPU ms", "client", "start s")
    return text_table(
        header,
        [
            (
                name, f"{row.rate:.0f}", f"{row.rate / base:.2f}", f"{row.mean:.1f}", f"{row.p50:.1f}",
                f"{row.p99:.1f}", f"{row.memory:.0f}", f"{row.work:.2f}", f"{row.own:.2f}", f"{row.ready:.1f}",
            )
            for name, row in rows.items()
        ],
    )  # fmt: skip


if __name__ == "__main__":
    main()
