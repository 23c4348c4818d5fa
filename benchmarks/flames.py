"""Where the server's time goes under load: a flame graph, and a table of shares by stage.

    python benchmarks/flames.py [--data DIR] [--parallel 16] [--seconds 10] [--output DIR]

Needs py-spy (`pip install py-spy`), which looks into the server's process from outside and hardly slows it. Writes
`server.svg`, a flame graph for a browser, and `server.txt`, its stacks, one a line with the number of samples.
"""

import argparse
import shutil
import subprocess
import sys
import threading
import time
from collections import Counter
from pathlib import Path

from common import data_or_sample
from serving import Setting, Timed, see_all_sections, serving, warm_up

from arramon.v1 import evaluation_pb2, types_pb2
from arramon_client.connection import METADATA, connect
from arramon_client.lanes import play_in_lanes
from arramon_client.play import Settings

SAMPLES = 500
"""A second."""

STAGES = (
    ("sections, made when first seen", ("Worlds.ground", "Worlds._made", "Worlds.scene")),
    ("drawing", ("RasterCamera.render", "World.render")),
    ("the view: what stands where", ("Worlds.render",)),
    ("journal: commit", ("Journal.commit",)),
    ("journal: the rest", ("Journal.",)),
    ("rules and scores", ("Session.apply", "Session.scores")),
    ("messages: images", ("Encoder.", "Shared.")),
    ("messages: the rest", ("Playing.",)),
    ("the engine's own", ("Engine.",)),
    ("idle", ("EpollSelector.select", "_worker (concurrent")),
    ("gRPC and the event loop", ("",)),
)
"""Each with what marks its stacks; the first that fits counts."""


def stage_of(stack: str) -> str:
    """Which stage a stack (`outermost;...;innermost`) belongs to."""
    return next(stage for stage, marks in STAGES if any(mark in stack for mark in marks))


def shares(stacks: str) -> dict[str, float]:
    """Each stage's share of the samples in which something was done.

    Args:
        stacks: a stack a line, and its number of samples after a space.
    """
    samples: Counter[str] = Counter()
    for line in stacks.splitlines():
        stack, _, count = line.rpartition(" ")
        samples[stage_of(stack)] += int(count)
    del samples["idle"]
    busy = max(samples.total(), 1)
    return {stage: samples[stage] / busy for stage, _ in STAGES if stage != "idle"}


def record(data: Path, setting: Setting, seconds: int, output: Path) -> tuple[str, float]:
    """Plays and looks on: the stacks, and the steps a second meanwhile."""
    with serving(data, setting) as (address, process, _), connect(address) as server:
        split = max(server.info.splits, key=lambda split: sum(split.episodes.values()))
        request = evaluation_pb2.CreateRunRequest(
            agent="profile", split=split.name, language=next(iter(split.episodes))
        )
        request.sensors.extend(setting.sensors)
        see_all_sections(server, request)
        run = server.stub.CreateRun(request, metadata=METADATA)
        agent, settings = Timed(), Settings(min(setting.parallel, run.episodes), setting.encoding)
        playing = threading.Thread(target=play_in_lanes, args=(server, run, agent, settings), daemon=True)
        playing.start()
        warm_up(agent, settings.parallel)
        agent.reset()
        started = time.perf_counter()
        stacks = output / "server.txt"
        look(process.pid, seconds, "raw", stacks)
        rate = agent.steps / (time.perf_counter() - started)
        look(process.pid, seconds, "flamegraph", output / "server.svg")
        server.stub.CancelRun(evaluation_pb2.CancelRunRequest(run_id=run.run_id), metadata=METADATA)
        playing.join()
    return stacks.read_text(), rate


def look(process_id: int, seconds: int, form: str, output: Path) -> None:
    """Records a process's stacks with py-spy."""
    command = ["py-spy", "record", "--pid", str(process_id), "--duration", str(seconds), "--rate", str(SAMPLES)]
    subprocess.run([*command, "--format", form, "--output", str(output)], check=True, capture_output=True)


def main() -> None:
    """Records, writes the files and prints the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--data", type=Path, help="data folder (default: the sample episodes)")
    parser.add_argument("--parallel", type=int, default=16, help="episodes open at once (default: %(default)s)")
    parser.add_argument("--encoding", default="SHARED", help="of images (default: %(default)s)")
    parser.add_argument("--seconds", type=int, default=10, help="to look on (default: %(default)s)")
    parser.add_argument("--output", type=Path, default=Path(), help="folder for the files (default: here)")
    options = parser.parse_args()
    if shutil.which("py-spy") is None:
        sys.exit("py-spy is not installed: pip install py-spy")
    options.output.mkdir(parents=True, exist_ok=True)
    encoding = types_pb2.Encoding.Value(f"ENCODING_{options.encoding.upper()}")
    setting = Setting("profile", parallel=options.parallel, encoding=encoding)
    with data_or_sample(options.data) as data:
        stacks, rate = record(data, setting, options.seconds, options.output)
    print(f"{options.parallel} episodes, {options.encoding.lower()}: {rate:.0f} steps a second while looked at")
    for stage, share in shares(stacks).items():
        print(f"{stage:32} {100 * share:5.1f}%")


if __name__ == "__main__":
    main()
