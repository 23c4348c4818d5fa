"""Frame rates of each camera in a real section, and of other environments on the same machine.

    python -m benchmarks.simulation.cameras [--data DIR] [--rounds 7] [--seconds 0.5] [--views 48]
                                            [--peers PYTHON] [--json FILE]

The views are those along the ground-truth paths, with the episodes' own objects. Without a data folder the sample
episodes are used. `--peers` names an interpreter with the packages `vizdoom` and `miniworld`, if it is not this one;
MiniWorld draws through EGL or, if DISPLAY is set, X. The rows alternate, round by round, so that changes of the
machine's speed affect all of them. The table shows medians, and their ratios to the other cameras.
"""

import os
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from argparse import Namespace
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from importlib.metadata import version
from itertools import cycle, islice
from typing import Any

from arramon_server.episodes.splits import Split, read_splits
from arramon_server.runs.play.session import EpisodeSession
from arramon_server.sim.bullet import ReferenceCamera
from arramon_server.sim.cameras import Camera
from arramon_server.sim.city import city_scene, refurnished
from arramon_server.sim.own_furniture import PAINTED, MovedProp, OwnFurniture, furnished
from arramon_server.sim.raster.camera import RasterCamera
from arramon_server.sim.rules import Limits
from arramon_server.sim.scene import Scene
from arramon_server.sim.section import Section
from arramon_server.sim.view import View, view
from benchmarks.common import (
    OpenGround,
    add_data,
    add_json,
    add_rounds,
    add_seconds,
    data_or_sample,
    parser_of,
    positive_int,
    text_table,
    write_json,
)
from benchmarks.simulation.peers import frames_per_second

VIEWS = 48

PEER_SECONDS = 2.0
"""Duration of a measurement of another environment."""

EPISODES, OWN = 16, 20
"""Number of episodes with furniture of their own, and number of props that each adds."""

PEERS = {"vizdoom": "ViZDoom, 320x240, RGB + depth", "miniworld": "MiniWorld, 224x224, RGB"}

FIRST_FRAME = """
import time
start = time.perf_counter()
from arramon_server.sim.raster.camera import compile_kernels
compile_kernels()
print(time.perf_counter() - start)
"""


@dataclass
class CameraRow:
    """A row of the table: its measurement, and its results by round."""

    name: str
    measure: Callable[[], float | None]
    rates: list[float] = field(default_factory=list)

    @property
    def median(self) -> float:
        """Median of the frames per second."""
        return statistics.median(self.rates)


def views_of(split: Split, section: str) -> Iterator[View]:
    """Yield every fifth view along the ground-truth paths in a section's streets."""
    for episode in split.in_playing_order(min(split.languages)):
        if episode.section == section:
            session = EpisodeSession(episode, OpenGround(), Limits(steps_per_phase=10_000))
            for turn in episode.turns:
                seen = [view(state, episode.layout) for state, _ in session.replay((*turn.actions, *turn.room_actions))]
                yield from [each for each in seen if not each.indoors][::5]


def refurnished_scenes(section: Section, scene: Scene, number: int) -> list[Scene]:
    """Return a section's scene with changed furniture, as in episodes with furniture of their own.

    One in six of the section's props is removed, one in six is moved by a unit, and `OWN` props are added.
    """
    made, count = [], len(section.props)
    for first in range(number):
        further = (section.props[(7 * first + i) % count] for i in range(OWN if count else 0))
        own = OwnFurniture(
            added=tuple(replace(prop, x=prop.x + 1.0, z=prop.z + 1.0) for prop in further if prop.kind != PAINTED),
            left_out=tuple(i for i in range(first % 6, count, 6) if section.props[i].kind != PAINTED),
            moved=tuple(
                MovedProp(i, section.props[i].x + 1.0, section.props[i].z, section.props[i].heading)
                for i in range((first + 1) % 6, count, 6)
                if section.props[i].kind != PAINTED
            ),
        )
        made.append(refurnished(scene, furnished(section, own)))
    return made


def drawing(
    cameras: Sequence[Camera],
    views: Sequence[View],
    size: int,
    seconds: float,
    *,
    segmentation: bool,
) -> Callable[[], float]:
    """Return a function that renders all views repeatedly for some seconds, and returns frames per second.

    Each view is rendered by the next camera.
    """

    def measure() -> float:
        frames, start = 0, time.perf_counter()
        while frames == 0 or time.perf_counter() - start < seconds:
            for seen, camera in zip(views, cycle(cameras), strict=False):
                camera.render(seen.viewpoint, seen.actors, size, segmentation=segmentation)
            frames += len(views)
        return frames / (time.perf_counter() - start)

    return measure


def _rows(
    reference: ReferenceCamera, fast: RasterCamera, views: list[View], own: Sequence[Scene], given: Namespace
) -> list[CameraRow]:
    rows, refurnished_cameras = [], [fast.showing(scene) for scene in own]
    for size in (224, 128):
        kinds: tuple[tuple[str, Sequence[Camera], bool], ...] = (
            (f"tiny, {size}, RGB + depth", [reference], False),
            (f"tiny, {size}, RGB + depth + segmentation", [reference], True),
            (f"raster, {size}, RGB + depth + segmentation", [fast], True),
            (f"raster, {size}, the same, own furniture", refurnished_cameras, True),
        )
        for name, cameras, segmentation in kinds:
            measure = drawing(cameras, views, size, given.seconds, segmentation=segmentation)
            rows.append(CameraRow(name, measure))
    return rows + [
        CameraRow(PEERS[name], partial(frames_per_second, given.peers, name, PEER_SECONDS)) for name in PEERS
    ]


def _first_frame(cache: str) -> float:
    """Return the seconds from importing the camera to its first frame, in a new process."""
    environment = os.environ | {"NUMBA_CACHE_DIR": cache}
    command = [sys.executable, "-c", FIRST_FRAME]
    return float(subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout)


def _ratio(row: CameraRow, other: CameraRow | None) -> str:
    return f"{row.median / other.median:.1f}" if other and other.rates else "-"


def _table(rows: Sequence[CameraRow]) -> str:
    by_name = {row.name: row for row in rows}
    lines = []
    for row in rows:
        if not row.rates:
            lines.append([row.name, "not installed", "", "", ""])
            continue
        size = 128 if "128" in row.name else 224
        ratios = [by_name[f"tiny, {size}, RGB + depth"], *(by_name[name] for name in PEERS.values())]
        lines.append([row.name, f"{row.median:.0f}", *(_ratio(row, other) for other in ratios)])
    return text_table(["", "frames/s", "x tiny", "x ViZDoom", "x MiniWorld"], lines)


def _machine() -> dict[str, Any]:
    return {
        "processor": platform.processor() or platform.machine(),
        "cores": os.cpu_count(),
        "python": platform.python_version(),
        **{name: version(name) for name in ("numba", "numpy", "pybullet")},
    }


def main() -> None:
    """Print the table."""
    parser = parser_of(__doc__)
    add_data(parser)
    add_rounds(parser, 7)
    add_seconds(parser, 0.5, "duration of each measurement of a camera, at least")
    parser.add_argument("--views", type=positive_int, default=VIEWS, help="number of views (default: %(default)s)")
    parser.add_argument("--peers", default=sys.executable, help="interpreter that has ViZDoom and MiniWorld")
    add_json(parser)
    arguments = parser.parse_args()
    with data_or_sample(arguments.data) as data, tempfile.TemporaryDirectory() as folder:
        split = next(iter(read_splits(data).values()))
        first = {"compiled anew": _first_frame(f"{folder}/numba"), "kept on disk": _first_frame(f"{folder}/numba")}
    section = min(split.sections)
    scene, views = city_scene(split.sections[section]), list(islice(views_of(split, section), arguments.views))
    own = refurnished_scenes(split.sections[section], scene, EPISODES)
    with ReferenceCamera(scene) as reference:
        rows = _rows(reference, RasterCamera(scene), views, own, arguments)
        for _ in range(arguments.rounds):
            for row in rows:
                rate = row.measure()
                row.rates += [] if rate is None else [rate]
    print(f"{split.name}, section {section}: {len(scene.bodies)} bodies, {len(views)} views\n{_table(rows)}")
    print("seconds to the fast camera's first frame: " + ", ".join(f"{k} {v:.1f}" for k, v in first.items()))
    rates = {row.name: row.rates for row in rows}
    write_json(arguments.json, {"machine": _machine(), "rates": rates, "first_frame_s": first})


if __name__ == "__main__":
    main()
