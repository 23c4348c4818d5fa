"""Profile of the server under load: a flame graph, and a table of shares by stage.

    python -m benchmarks.serving.flames [--data DIR] [--parallel 16] [--seconds 10] [--output DIR]

Needs py-spy (`pip install py-spy`), which samples the server's process from outside with little overhead. Writes
`server.svg`, a flame graph for a browser, and `server.txt`, its stacks, one per line with the number of samples.
"""

import argparse
import shutil
import subprocess
import sys
import threading
import time
from collections import Counter
from pathlib import Path

from arramon.v1 import evaluation_pb2, types_pb2
from arramon_client.multi_stream import play_streams
from arramon_client.play import Settings
from arramon_client.transport.connection import METADATA, connect
from benchmarks.common import data_or_sample
from benchmarks.serving.steps import Setting, Timed, see_all_sections, serving, warm_up

SAMPLES = 500
"""Samples per second."""

STAGES = (
    ("sections, built on first use", ("Worlds.ground", "Worlds._made", "Worlds.scene")),
    ("drawing", ("RasterCamera.render", "World.render")),
    ("view: poses of the objects", ("Worlds.render",)),
    ("journal: commit", ("Journal.commit",)),
    ("journal: the rest", ("Journal.",)),
    ("rules and scores", ("Session.apply", "Session.scores")),
    ("messages: images", ("Encoder.", "Shared.")),
    ("messages: the rest", ("Playing.",)),
    ("the engine itself", ("Engine.",)),
    ("idle", ("EpollSelector.select", "_worker (concurrent")),
    ("gRPC and the event loop", ("",)),
)
"""Stages, each with substrings that identify its stacks; the first match counts."""


def stage_of(stack: str) -> str:
    """Return the stage of a stack (`outermost;...;innermost`)."""
    return next(stage for stage, marks in STAGES if any(mark in stack for mark in marks))


def shares(stacks: str) -> dict[str, float]:
    """Return each stage's share of the samples that are not idle.

    Args:
        stacks: one stack per line, followed by a space and its number of samples.
    """
    samples: Counter[str] = Counter()
    for line in stacks.splitlines():
        stack, _, count = line.rpartition(" ")
        samples[stage_of(stack)] += int(count)
    del samples["idle"]
    busy = max(samples.total(), 1)
    return {stage: samples[stage] / busy for stage, _ in STAGES if stage != "idle"}


def record(data: Path, setting: Setting, seconds: int, output: Path) -> tuple[str, float]:
    """Play and record: return the stacks, and the steps per second meanwhile."""
    with serving(data, setting) as (address, process, _), connect(address) as server:
        split = max(server.info.splits, key=lambda split: sum(split.episodes.values()))
        request = evaluation_pb2.CreateRunRequest(
            agent="profile", split=split.name, language=next(iter(split.episodes))
        )
        request.sensors.extend(setting.sensors)
        see_all_sections(server, request)
        run = server.stub.CreateRun(request, metadata=METADATA)
        agent, settings = Timed(), Settings(min(setting.parallel, run.episodes), setting.encoding)
        playing = threading.Thread(target=play_streams, args=(server, run, agent, settings), daemon=True)
        playing.start()
        warm_up(agent, settings.parallel)
        agent.reset()
        started = time.perf_counter()
        stacks = output / "server.txt"
        record_stacks(process.pid, seconds, "raw", stacks)
        rate = agent.steps / (time.perf_counter() - started)
        record_stacks(process.pid, seconds, "flamegraph", output / "server.svg")
        server.stub.CancelRun(evaluation_pb2.CancelRunRequest(run_id=run.run_id), metadata=METADATA)
        playing.join()
    return stacks.read_text(), rate


def record_stacks(process_id: int, seconds: int, form: str, output: Path) -> None:
    """Record a process's stacks with py-spy."""
    command = ["py-spy", "record", "--pid", str(process_id), "--duration", str(seconds), "--rate", str(SAMPLES)]
    subprocess.run([*command, "--format", form, "--output", str(output)], check=True, capture_output=True)


def main() -> None:
    """Record the profile, write its files and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--data", type=Path, help="data folder (default: the sample episodes)")
    parser.add_argument("--parallel", type=int, default=16, help="episodes open at once (default: %(default)s)")
    parser.add_argument("--encoding", default="SHARED", help="encoding of images (default: %(default)s)")
    parser.add_argument("--seconds", type=int, default=10, help="duration of a recording (default: %(default)s)")
    parser.add_argument("--output", type=Path, default=Path(), help="folder for the files (default: here)")
    options = parser.parse_args()
    if shutil.which("py-spy") is None:
        sys.exit("py-spy is not installed: pip install py-spy")
    options.output.mkdir(parents=True, exist_ok=True)
    encoding = types_pb2.Encoding.Value(f"ENCODING_{options.encoding.upper()}")
    setting = Setting("profile", parallel=options.parallel, encoding=encoding)
    with data_or_sample(options.data) as data:
        stacks, rate = record(data, setting, options.seconds, options.output)
    print(f"{options.parallel} episodes, {options.encoding.lower()}: {rate:.0f} steps per second while recorded")
    for stage, share in shares(stacks).items():
        print(f"{stage:32} {100 * share:5.1f}%")


if __name__ == "__main__":
    main()
