"""Comparison of the fast camera with the reference camera, in every section, the project's own sections and the room.

    python -m benchmarks.simulation.camera_agreement [--data DIR] [--poses 2100] [--size 224] [--pictures DIR]
                                                     [--json FILE]

In a split's sections and in the room the poses are those along the ground-truth paths, with the episodes' objects. In
the project's own sections they are random poses on the streets' middle lines, with objects ahead. Without a data folder
the sample episodes are used. Depth agrees within 0.01 units or 0.5%, segmentation if the label is the same. "Worst" is
the lowest share of agreeing pixels in one frame. "Beyond edges" counts disagreeing pixels without an adjacent edge
(another label, or a depth step of 5%) in the reference; "unexplained" counts those that also have no fainter adjacent
edge (1%, as between a pavement and its kerb), no edge two pixels away, and none in the other frame. "Colour" is the
mean absolute difference, 0 to 255, with and without mipmaps, which the reference lacks.
"""

import sys
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from itertools import islice, pairwise
from math import cos, hypot, radians, sin
from pathlib import Path
from random import Random

import numpy as np
import numpy.typing as npt
from PIL import Image

from arramon_dataset.plans import Plan, build_section, plan_ids, read_plan
from arramon_server.episodes.splits import Split, read_splits
from arramon_server.runs.play.session import EpisodeSession
from arramon_server.sim.bullet import ReferenceCamera
from arramon_server.sim.cameras import Actor, Frame, Viewpoint
from arramon_server.sim.catalogue import ALL_TYPES
from arramon_server.sim.city import city_scene
from arramon_server.sim.raster.camera import RasterCamera
from arramon_server.sim.room_scene import room_scene
from arramon_server.sim.rules import Limits
from arramon_server.sim.scene import Scene
from arramon_server.sim.view import View, view
from benchmarks.common import (
    OpenGround,
    add_data,
    add_json,
    data_or_sample,
    parser_of,
    positive_int,
    text_table,
    write_json,
)

NEAR_ENOUGH, SHARE = 10, 0.005
"""Tolerance of depth: in thousandths of a unit, and as a share of the depth."""

OBJECTS = 6
"""Number of objects ahead of the camera in each pose of an own section."""

SEED = "arramon"
"""Seed of own sections and of the poses in them."""

SUMMED = (
    *("poses", "pixels", "depth", "segmentation"),
    *("beyond_edges", "unexplained", "colour", "colour_without_mipmaps"),
)
"""Fields that are summed in the total row."""

Mask = npt.NDArray[np.bool_]


@dataclass
class PlaceAgreement:
    """Agreement of the cameras in one place: a section, or the room."""

    place: str
    poses: int = 0
    pixels: int = 0
    depth: int = 0
    segmentation: int = 0
    worst_depth: float = 1.0
    worst_segmentation: float = 1.0
    beyond_edges: int = 0
    unexplained: int = 0
    colour: float = 0.0
    colour_without_mipmaps: float = 0.0

    def add(self, reference: Frame, fast: Frame, plain: Frame) -> Mask:
        """Add one pose; return a mask of the pixels in which the frames disagree."""
        far, same = compare_frames(reference, fast)
        wrong: Mask = far | ~same
        self.poses += 1
        self.pixels += far.size
        self.depth += int((~far).sum())
        self.segmentation += int(same.sum())
        self.worst_depth = min(self.worst_depth, 1 - float(far.mean()))
        self.worst_segmentation = min(self.worst_segmentation, float(same.mean()))
        beyond = wrong & ~edge_mask(reference)
        if beyond.any():
            self.beyond_edges += int(beyond.sum())
            explained = edge_mask(reference, jump=0.01) | edge_mask(reference, reach=2) | edge_mask(fast)
            self.unexplained += int((beyond & ~explained).sum())
        self.colour += _difference(reference, fast)
        self.colour_without_mipmaps += _difference(reference, plain)
        return wrong


def compare_frames(reference: Frame, fast: Frame) -> tuple[Mask, Mask]:
    """Return two masks: pixels whose depths differ, and pixels whose labels are equal."""
    assert reference.segmentation is not None
    assert fast.segmentation is not None
    here, there = reference.depth.astype(np.int64), fast.depth.astype(np.int64)
    far = (np.abs(here - there) > np.maximum(NEAR_ENOUGH, SHARE * here)) | ((here == 0) != (there == 0))
    return far, reference.segmentation == fast.segmentation


def edge_mask(frame: Frame, *, jump: float = 0.05, reach: int = 1) -> Mask:
    """Return the pixels with another label, or a depth that differs by the share `jump`, within `reach` pixels."""
    assert frame.segmentation is not None
    labels = np.pad(frame.segmentation, reach, mode="edge")
    depth = np.pad(frame.depth.astype(float), reach, mode="edge")
    height, width = frame.depth.shape
    found = np.zeros((height, width), bool)
    for i in range(2 * reach + 1):
        for j in range(2 * reach + 1):
            near = slice(i, i + height), slice(j, j + width)
            found |= labels[near] != frame.segmentation
            found |= np.abs(depth[near] - frame.depth) > jump * frame.depth
    return found


def _difference(a: Frame, b: Frame) -> float:
    return float(np.abs(a.rgb.astype(np.int16) - b.rgb).mean())


def _views(split: Split, section: str | None, every: int) -> Iterator[View]:
    """Yield every `every`-th view along the ground-truth paths in a section, or in the room if `section` is None."""
    language = min(split.languages)
    met = 0
    for episode in split.in_playing_order(language):
        if section is not None and episode.section != section:
            continue
        session = EpisodeSession(episode, OpenGround(), Limits(steps_per_phase=10_000))
        for turn in episode.turns:
            for state, _ in session.replay((*turn.actions, *turn.room_actions)):
                seen = view(state, episode.layout)
                if seen.indoors == (section is None):
                    met += 1
                    if met % every == 0:
                        yield seen


def _views_along(plan: Plan) -> Iterator[View]:
    """Yield random views, without end, from points uniformly distributed on the streets' middle lines."""
    random = Random(f"{SEED} {plan.id}")  # noqa: S311 - the same poses in every run
    ends = [(*start, *end) for line in plan.lines() for start, end in pairwise(line.tolist())]
    lengths = [hypot(c - a, d - b) for a, b, c, d in ends]
    while True:
        ((a, b, c, d),) = random.choices(ends, lengths)
        share, heading = random.random(), random.uniform(0.0, 360.0)
        x, z = a + share * (c - a), b + share * (d - b)
        actors = []
        for type_ in random.sample(ALL_TYPES, OBJECTS):
            away, aside = random.uniform(1.0, 9.0), radians(heading + random.uniform(-30.0, 30.0))
            place = x + away * sin(aside), z + away * cos(aside), 0.0
            actors.append(Actor(type_, place, heading=random.uniform(0.0, 360.0)))
        yield View(indoors=False, viewpoint=Viewpoint(x, z, heading), actors=tuple(actors))


def _compare(place: str, scene: Scene, views: Iterator[View], size: int, pictures: Path | None) -> PlaceAgreement:
    row, worst = PlaceAgreement(place), 0
    fast, plain = RasterCamera(scene), RasterCamera(scene, mipmaps=False)
    with ReferenceCamera(scene) as reference:
        for seen in views:
            cameras = (reference, fast, plain)
            frames = [camera.render(seen.viewpoint, seen.actors, size, segmentation=True) for camera in cameras]
            wrong = row.add(*frames)
            if pictures and wrong.sum() > worst:
                worst = int(wrong.sum())
                mask = np.repeat(wrong[..., None] * np.uint8(255), 3, axis=2)
                sheet = np.hstack([frame.rgb for frame in frames] + [mask])
                Image.fromarray(sheet).save(pictures / f"{place.replace(' ', '-')}.png")
    return row


def _table(rows: Sequence[PlaceAgreement]) -> str:
    total = PlaceAgreement("all")
    for row in rows:
        for name in SUMMED:
            setattr(total, name, getattr(total, name) + getattr(row, name))
        total.worst_depth = min(total.worst_depth, row.worst_depth)
        total.worst_segmentation = min(total.worst_segmentation, row.worst_segmentation)
    header = (
        "place",
        "poses",
        "depth %",
        "worst",
        "segm. %",
        "worst",
        "beyond edges",
        "unexplained",
        "colour",
        "no mips",
    )
    lines = [
        (
            row.place, f"{row.poses}", f"{100 * row.depth / row.pixels:.4f}", f"{100 * row.worst_depth:.3f}",
            f"{100 * row.segmentation / row.pixels:.4f}", f"{100 * row.worst_segmentation:.3f}",
            f"{row.beyond_edges}", f"{row.unexplained}", f"{row.colour / row.poses:.2f}",
            f"{row.colour_without_mipmaps / row.poses:.3f}",
        )
        for row in (*rows, total)
        if row.poses
    ]  # fmt: skip
    return text_table(header, lines)


def _places(splits: Sequence[Split], own: Sequence[str]) -> Iterator[tuple[str, Scene, Iterator[View]]]:
    for split in splits:
        for section in split.sections:
            yield f"{split.name} {section}", city_scene(split.sections[section]), _views(split, section, every=7)
    for plan in map(read_plan, own):
        yield f"own section {plan.id}", city_scene(build_section(plan, SEED)), _views_along(plan)
    yield "room", room_scene(), _views(splits[0], None, every=7)


def main() -> int:
    """Print the table; return 1 if the cameras agree on less than 99.5% of the pixels."""
    parser = parser_of(__doc__)
    add_data(parser)
    parser.add_argument(
        "--poses", type=positive_int, default=2100, help="total number of poses, the same for each place"
    )
    parser.add_argument("--own", nargs="*", default=plan_ids(), help="own sections to compare (default: all)")
    parser.add_argument("--size", type=positive_int, default=224, help="side of the frames in pixels")
    parser.add_argument("--pictures", type=Path, help="folder for the worst frame of each place")
    add_json(parser)
    arguments = parser.parse_args()
    with data_or_sample(arguments.data) as data:
        splits = list(read_splits(data).values())
    if arguments.pictures:
        arguments.pictures.mkdir(parents=True, exist_ok=True)
    each = -(-arguments.poses // (sum(len(split.sections) for split in splits) + len(arguments.own) + 1))
    rows = [
        _compare(place, scene, islice(views, each), arguments.size, arguments.pictures)
        for place, scene, views in _places(splits, arguments.own)
    ]
    print(_table(rows))
    write_json(arguments.json, {"size": arguments.size, "places": [asdict(row) for row in rows]})
    pixels = sum(row.pixels for row in rows)
    agreeing = min(sum(row.depth for row in rows), sum(row.segmentation for row in rows))
    return 0 if agreeing >= 0.995 * pixels else 1


if __name__ == "__main__":
    sys.exit(main())
