"""Startup time, and scaling with open episodes, with streams, and with the bodies of a section.

    python -m benchmarks.serving.growth [--data DIR] [--seconds 4] [--rounds 3] [--only PART] [--json FILE]

All over a Unix socket with shared memory, RGB and depth of 224x224, without fsync, with a random walk. The server's
memory is measured with all sections built. Bodies are removed evenly from the largest section, which is drawn in this
process. The first start on a machine compiles the camera; it is simulated with an empty cache folder.
"""

import statistics
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import replace
from itertools import islice
from pathlib import Path

from arramon_client.play import Settings
from arramon_client.transport.connection import connect
from arramon_server.episodes.splits import Split
from arramon_server.sim.city import city_scene
from arramon_server.sim.physics import Physics, physics_of
from arramon_server.sim.raster.camera import RasterCamera
from arramon_server.sim.scene import Scene
from arramon_server.sim.view import View
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
from benchmarks.serving.play import (
    TimedRandomWalk,
    background_play,
    build_all_sections,
    measure_play,
    run_request,
    with_fewer_episodes,
)
from benchmarks.serving.server import ServerSetting, running_server
from benchmarks.simulation.cameras import VIEWS, drawing, views_of

EPISODES = (1, 16, 128, 1000)
MIN_MEASURED_EPISODES = 100
"""Minimum number of open episodes for which their memory exceeds the noise."""

STREAMS = (1, 2, 4, 16)
SHARES = (0.25, 0.5, 0.75, 1.0)
DRAWING_SECONDS = 0.5
"""Minimum duration of a camera measurement, in seconds."""

PARTS = ("starts", "loads", "bodies")
COLUMNS = {
    "steps/s": 0, "mean ms": 1, "p99 ms": 1, "MB": 0, "MB each": 2, "seconds": 2, "frames/s": 0, "rules us": 1,
}  # fmt: skip
"""Columns of the table, with their decimals."""

Figures = dict[str, float]


def measure_starts(data: Path) -> Iterator[tuple[str, Figures]]:
    """Measure the first start of a server on a machine, and a later one."""
    with tempfile.TemporaryDirectory() as folder:
        for name in ("first start on a machine", "later start"):
            with running_server(data, ServerSetting(name), environment={"NUMBA_CACHE_DIR": folder}) as process:
                yield name, {"seconds": process.ready, "MB": process.memory}


def measure_loads(data: Path, split: Split, seconds: float) -> Iterator[tuple[str, Figures]]:
    """Measure episodes open on one stream, then 16 episodes on several streams, all on one server."""
    setting = ServerSetting("growth")
    with running_server(data, setting) as process, connect(process.address) as server:
        request = run_request(split)
        build_all_sections(server, request, seconds)
        empty = process.memory

        def under(streams: int, episodes: int) -> Figures:
            agent, settings = TimedRandomWalk(), Settings(episodes // streams, setting.encoding)
            fewer = with_fewer_episodes(server, request, 4 * episodes + 16)
            with background_play(server, fewer, agent, settings, streams=streams, warm_up=seconds):
                found = measure_play(agent, seconds)
                return {"steps/s": found.rate, "mean ms": found.mean, "p99 ms": found.p99, "MB": process.memory}

        for episodes in EPISODES:
            if episodes <= len(split.episodes):
                figures = under(1, episodes)
                if episodes >= MIN_MEASURED_EPISODES:
                    figures["MB each"] = (figures["MB"] - empty) / episodes
                yield f"{episodes} open episodes", figures
        for streams in STREAMS:
            yield f"16 episodes on {streams} streams", under(streams, 16)


def measure_bodies(split: Split, seconds: float) -> Iterator[tuple[str, Figures]]:
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
            rate = statistics.median(drawing([camera], views, 224, seconds, segmentation=False)() for _ in range(3))
            figures = {"seconds": made, "frames/s": rate, "rules us": 1e6 * seconds_per_check(ground, views)}
        yield f"{len(scene.bodies)} bodies", figures


def with_share_of_bodies(scene: Scene, share: float) -> Scene:
    """Return the scene with an evenly chosen share of its solid bodies."""
    solid = [body for body in scene.bodies if body.collider is not None]
    kept = {body.name for number, body in enumerate(solid) if int((number + 1) * share) > int(number * share)}
    return replace(scene, bodies=tuple(body for body in scene.bodies if body.collider is None or body.name in kept))


def seconds_per_check(ground: Physics, views: Sequence[View]) -> float:
    """Return the seconds per collision check of a step ahead."""
    steps_ahead = [((seen.viewpoint.x, seen.viewpoint.y), (seen.viewpoint.x + 1.0, seen.viewpoint.y)) for seen in views]
    started = time.perf_counter()
    for _ in range(20):
        for start, end in steps_ahead:
            ground.way_is_free(start, end)
    return (time.perf_counter() - started) / (20 * len(steps_ahead))


def table(rows: dict[str, list[Figures]]) -> str:
    """Return the table of medians; missing values stay empty."""
    lines = [
        [
            name,
            *(
                f"{statistics.median(each[column] for each in rounds):.{digits}f}" if column in rounds[0] else ""
                for column, digits in COLUMNS.items()
            ),
        ]
        for name, rounds in rows.items()
    ]
    return text_table(["", *COLUMNS], lines)


def main() -> None:
    """Run the benchmark and print its table."""
    parser = parser_of(__doc__)
    add_data(parser)
    add_seconds(parser, 4.0, "duration of each load")
    add_rounds(parser, 3)
    parser.add_argument("--only", choices=PARTS, action="append", help="a part (default: all)")
    add_json(parser)
    options = parser.parse_args()
    rows: dict[str, list[Figures]] = {}
    with data_or_sample(options.data) as data:
        split = largest_split(data)
        parts = {
            "starts": lambda: measure_starts(data),
            "loads": lambda: measure_loads(data, split, options.seconds),
            "bodies": lambda: measure_bodies(split, min(options.seconds, DRAWING_SECONDS)),
        }
        for _ in range(options.rounds):
            for part in options.only or PARTS:
                for name, figures in parts[part]():
                    rows.setdefault(name, []).append(figures)
    print(f"split {split.name}, {len(split.episodes)} episodes\n{table(rows)}")
    write_json(options.json, {"split": split.name, "rounds": rows})


if __name__ == "__main__":
    main()
