"""Startup time, and scaling with open episodes, with streams, and with the bodies of a section.

    python -m benchmarks.serving.growth [--data DIR] [--seconds 4] [--rounds 3] [--json FILE]

All over a Unix socket with shared memory, RGB and depth of 224x224, without fsync, with a random walk. The server's
memory is measured with all sections built. Bodies are removed evenly from the largest section, which is drawn in this
process. The first start on a machine compiles the camera; it is simulated with an empty cache folder.
"""

import argparse
import json
import statistics
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import replace
from itertools import islice
from pathlib import Path

from arramon.v1 import evaluation_pb2
from arramon_client.play import Settings, play
from arramon_client.transport.connection import METADATA, Server, connect
from arramon_server.episodes.splits import Split, read_splits
from arramon_server.sim.city import city_scene
from arramon_server.sim.physics import Physics, physics_of
from arramon_server.sim.raster.camera import RasterCamera
from arramon_server.sim.scene import Scene
from arramon_server.sim.view import View
from benchmarks.common import data_or_sample
from benchmarks.serving.steps import Setting, Timed, family, resident, see_all_sections, serving, some, warm_up
from benchmarks.simulation.cameras import VIEWS, drawing, views_of

EPISODES = (1, 16, 128, 1000)
ENOUGH = 100
"""Number of open episodes from which on their memory exceeds the noise."""

STREAMS = (1, 2, 4, 16)
SHARES = (0.25, 0.5, 0.75, 1.0)

Figures = dict[str, float]


def starts(data: Path) -> Iterator[tuple[str, Figures]]:
    """Measure a server's first start on a machine, and a later one."""
    with tempfile.TemporaryDirectory() as folder:
        for name in ("first start on a machine", "later start"):
            with serving(data, Setting(name), {"NUMBA_CACHE_DIR": folder}) as (_, process, ready):
                yield name, {"seconds": ready, "MB": memory(process.pid)}


def loads(data: Path, split: Split, seconds: float) -> Iterator[tuple[str, Figures]]:
    """Measure episodes open on one stream, then 16 episodes on several streams, all on one server."""
    setting = Setting("growth")
    with serving(data, setting) as (address, process, _), connect(address) as server:
        request = evaluation_pb2.CreateRunRequest(agent="growth", split=split.name, language=min(split.languages))
        request.sensors.extend(setting.sensors)
        see_all_sections(server, request)
        empty = memory(process.pid)

        def under(streams: int, episodes: int) -> Figures:
            with playing(server, request, streams, episodes) as agent:
                figures = measure_play(agent, seconds)
                return {**figures, "MB": memory(process.pid)}

        for episodes in EPISODES:
            if episodes <= len(split.episodes):
                figures = under(1, episodes)
                if episodes >= ENOUGH:
                    figures["MB each"] = (figures["MB"] - empty) / episodes
                yield f"{episodes} open episodes", figures
        for streams in STREAMS:
            yield f"16 episodes on {streams} streams", under(streams, 16)


@contextmanager
def playing(server: Server, request: evaluation_pb2.CreateRunRequest, streams: int, episodes: int) -> Iterator[Timed]:
    """Play a run on several streams with an equal share of the episodes; yields their common agent."""
    run = server.stub.CreateRun(some(server, request, 4 * episodes + 16), metadata=METADATA)
    agent, settings = Timed(), Settings(episodes // streams, Setting("").encoding)
    arguments = server.stub, run, agent, settings
    threads = [threading.Thread(target=play, args=arguments, daemon=True) for _ in range(streams)]
    for thread in threads:
        thread.start()
    warm_up(agent, episodes)
    yield agent
    server.stub.CancelRun(evaluation_pb2.CancelRunRequest(run_id=run.run_id), metadata=METADATA)
    for thread in threads:
        thread.join()


def measure_play(agent: Timed, seconds: float) -> Figures:
    """Measure an agent's play for some seconds."""
    agent.reset()
    started = time.perf_counter()
    time.sleep(seconds)
    steps, waits, elapsed = agent.steps, sorted(agent.waits), time.perf_counter() - started
    mean = statistics.fmean(waits)
    return {"steps/s": steps / elapsed, "mean ms": 1e3 * mean, "p99 ms": 1e3 * waits[len(waits) * 99 // 100]}


def bodies(split: Split) -> Iterator[tuple[str, Figures]]:
    """Measure the largest section with shares of its bodies."""
    section = max(split.sections, key=lambda name: len(city_scene(split.sections[name]).bodies))
    whole, views = city_scene(split.sections[section]), list(islice(views_of(split, section), VIEWS))
    RasterCamera(whole)  # builds what all cameras share
    for share in SHARES:
        scene = with_share_of_bodies(whole, share)
        started = time.perf_counter()
        with closing(physics_of(scene)) as ground:
            camera = RasterCamera(scene)
            made = time.perf_counter() - started
            rate = statistics.median(drawing(camera, views, 224, segmentation=False)() for _ in range(3))
            figures = {"seconds": made, "frames/s": rate, "rules us": 1e6 * seconds_per_check(ground, views)}
        yield f"{len(scene.bodies)} bodies", figures


def with_share_of_bodies(scene: Scene, share: float) -> Scene:
    """Return the scene with an evenly chosen share of its solid bodies."""
    solid = [body for body in scene.bodies if body.collider is not None]
    kept = {body.name for number, body in enumerate(solid) if int((number + 1) * share) > int(number * share)}
    return replace(scene, bodies=tuple(body for body in scene.bodies if body.collider is None or body.name in kept))


def seconds_per_check(ground: Physics, views: Sequence[View]) -> float:
    """Return the seconds per collision check of a step ahead."""
    ways = [((seen.viewpoint.x, seen.viewpoint.y), (seen.viewpoint.x + 1.0, seen.viewpoint.y)) for seen in views]
    started = time.perf_counter()
    for _ in range(20):
        for start, end in ways:
            ground.way_is_free(start, end)
    return (time.perf_counter() - started) / (20 * len(ways))


def memory(process_id: int) -> float:
    """Return the resident memory of a server's processes, in MB."""
    return sum(map(resident, family(process_id)))


def table(rows: dict[str, list[Figures]]) -> str:
    """Return the table of medians; missing values stay empty."""
    columns = {
        "steps/s": 0,
        "mean ms": 1,
        "p99 ms": 1,
        "MB": 0,
        "MB each": 2,
        "seconds": 2,
        "frames/s": 0,
        "rules us": 1,
    }
    lines = [f"{'':28}" + "".join(f"{name:>10}" for name in columns)]
    for name, rounds in rows.items():
        cells = [
            f"{statistics.median(each[column] for each in rounds):10.{digits}f}" if column in rounds[0] else " " * 10
            for column, digits in columns.items()
        ]
        lines.append(f"{name:28}" + "".join(cells).rstrip())
    return "\n".join(lines)


def main() -> int:
    """Run the benchmark and print its table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, help="data folder (default: the sample episodes)")
    parser.add_argument("--seconds", type=float, default=4.0, help="duration of each load (default: %(default)s)")
    parser.add_argument("--rounds", type=int, default=3, help="number of rounds (default: %(default)s)")
    parser.add_argument("--json", type=Path, help="output file for the results")
    options = parser.parse_args()
    rows: dict[str, list[Figures]] = {}
    with data_or_sample(options.data) as data:
        split = max(read_splits(data).values(), key=lambda split: len(split.episodes))
        parts: list[Callable[[], Iterator[tuple[str, Figures]]]] = [
            lambda: starts(data),
            lambda: loads(data, split, options.seconds),
            lambda: bodies(split),
        ]
        for _ in range(options.rounds):
            for part in parts:
                for name, figures in part():
                    rows.setdefault(name, []).append(figures)
    print(f"split {split.name}, {len(split.episodes)} episodes\n{table(rows)}")
    if options.json:
        options.json.write_text(json.dumps({"split": split.name, "rounds": rows}, indent=1) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
