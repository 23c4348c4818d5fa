"""Profile of the server under load: a flame graph, and a table of CPU shares by stage.

    python -m benchmarks.serving.flames [--data DIR] [--parallel 16] [--seconds 10] [--output DIR]

Needs py-spy (`pip install py-spy`), which samples the server's process from outside with little overhead. Writes
`server.svg`, a flame graph for a browser, and `server.txt`, its stacks, one per line with the number of samples.
"""

import os
import shutil
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from selectors import EpollSelector
from typing import Any

from arramon.v1 import types_pb2
from arramon_client.play import Settings
from arramon_client.transport.connection import connect
from arramon_server.api.encoding import MessageEncoder
from arramon_server.api.event_sender import EventSender
from arramon_server.api.play_stream import PlayHandler
from arramon_server.api.shared_memory import SharedImages, SharedMemoryEncoder
from arramon_server.runs.play.engine import Engine
from arramon_server.runs.play.session import EpisodeSession
from arramon_server.runs.play.worlds import Worlds
from arramon_server.runs.storage.journal import Journal
from arramon_server.runs.storage.metered_journal import MeteredJournal
from arramon_server.sim.raster.camera import RasterCamera
from arramon_server.sim.section_world import EpisodeWorld
from benchmarks.common import add_data, data_or_sample, largest_split, parser_of, positive_int, text_table
from benchmarks.serving.play import TimedRandomWalk, background_play, build_all_sections, run_request
from benchmarks.serving.server import ServerSetting, running_server

SAMPLES = 500
"""Samples per second."""

Code = type | Callable[..., Any]
"""A function, or a class for all of its methods."""

STAGES: dict[str, tuple[Code, ...]] = {
    "worlds, built when episodes are opened": (Worlds.load, Worlds.world),
    "drawing": (RasterCamera.render,),
    "view: poses of the objects": (EpisodeWorld.render,),
    "journal: commit": (MeteredJournal.commit, Journal.commit),
    "journal: the rest": (MeteredJournal, *Journal.__mro__[:-1]),
    "rules and scores": (EpisodeSession.apply, EpisodeSession.scores),
    "messages: images": (MessageEncoder, SharedMemoryEncoder, SharedImages),
    "messages: the rest": (PlayHandler, EventSender),
    "the engine itself": (Engine,),
}
"""Stages, each with the code that identifies its stacks; the first match counts."""

WAITS: tuple[Code, ...] = (EpollSelector.select,)
IDLE = "_worker (concurrent"
"""Marks of stacks that wait: code, and a worker of a thread pool that has nothing to do."""

REST = "gRPC and the event loop"
"""The stage of all other stacks."""


def profiler_prefix(code: Code) -> str:
    """Return the prefix that py-spy gives the name of a function, or of a class's methods."""
    if isinstance(code, type):
        return f"{code.__qualname__}."
    name: str = code.__qualname__
    return f"{name} ("


def stage_of(stack: str) -> str:
    """Return the stage of a stack (`outermost;...;innermost`); empty if it waits."""
    frames = stack.split(";")
    if frames[-1].startswith((IDLE, *map(profiler_prefix, WAITS))):
        return ""
    for stage, codes in STAGES.items():
        if any(frame.startswith(tuple(map(profiler_prefix, codes))) for frame in frames):
            return stage
    return REST


def stage_shares(stacks: str) -> dict[str, float]:
    """Return each stage's share of the samples that do not wait.

    Args:
        stacks: one stack per line, followed by a space and its number of samples.
    """
    samples: Counter[str] = Counter()
    for line in stacks.splitlines():
        stack, _, count = line.rpartition(" ")
        samples[stage_of(stack)] += int(count)
    del samples[""]
    busy = max(samples.total(), 1)
    return {stage: samples[stage] / busy for stage in (*STAGES, REST)}


def record(data: Path, setting: ServerSetting, seconds: int, output: Path) -> tuple[str, float]:
    """Play and record: return the stacks, and the steps per second meanwhile."""
    with running_server(data, setting) as process, connect(process.address) as server:
        request, agent = run_request(largest_split(data), setting.sensors), TimedRandomWalk()
        build_all_sections(server, request)
        with background_play(server, request, agent, Settings(setting.parallel, setting.encoding)):
            agent.reset()
            started, stacks = time.perf_counter(), output / "server.txt"
            record_stacks(process.pid, seconds, "raw", stacks)
            rate = agent.steps / (time.perf_counter() - started)
            record_stacks(process.pid, seconds, "flamegraph", output / "server.svg")
    return stacks.read_text(), rate


def record_stacks(process_id: int, seconds: int, form: str, output: Path) -> None:
    """Record a process's stacks with py-spy.

    Raises:
        SystemExit: if py-spy is not installed, or lacks permission to inspect the process.
    """
    places = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")])
    program = shutil.which("py-spy", path=places)
    if program is None:
        sys.exit("py-spy is not installed: pip install py-spy")
    command = [program, "record", "--pid", str(process_id), "--duration", str(seconds), "--rate", str(SAMPLES)]
    done = subprocess.run([*command, "--format", form, "--output", str(output)], capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"py-spy ended with status {done.returncode}: {done.stderr.strip()}")


def main() -> None:
    """Record the profile, write its files and print the table."""
    parser = parser_of(__doc__)
    add_data(parser)
    parser.add_argument(
        "--parallel", type=positive_int, default=16, help="episodes open at once (default: %(default)s)"
    )
    encodings = [name.removeprefix("ENCODING_") for name in types_pb2.Encoding.keys()[1:]]
    parser.add_argument(
        "--encoding", type=str.upper, choices=encodings, default="SHARED", help="of images (default: %(default)s)"
    )
    parser.add_argument(
        "--seconds", type=positive_int, default=10, help="duration of a recording (default: %(default)s)"
    )
    parser.add_argument("--output", type=Path, default=Path(), help="folder for the files (default: here)")
    options = parser.parse_args()
    options.output.mkdir(parents=True, exist_ok=True)
    encoding = types_pb2.Encoding.Value(f"ENCODING_{options.encoding}")
    setting = ServerSetting("profile", parallel=options.parallel, encoding=encoding)
    with data_or_sample(options.data) as data:
        stacks, rate = record(data, setting, options.seconds, options.output)
    print(f"{options.parallel} episodes, {options.encoding.lower()}: {rate:.0f} steps per second while recorded")
    print(
        text_table(
            ("of the busy time", "%"), [(name, f"{100 * share:.1f}") for name, share in stage_shares(stacks).items()]
        )
    )


if __name__ == "__main__":
    main()
