"""Costs of each image encoding: microseconds to encode and to decode, kilobytes, milliseconds on a slow link.

    python -m benchmarks.serving.encodings [--frames 24] [--rounds 9] [--json FILE]

The frames are views along the ground-truth paths of the sample episodes, drawn by the reference camera. Encoding is the
server's code up to the message, decoding the client's from the message to the array. The encodings alternate, round by
round, so that changes of the machine's speed affect all of them. The table shows the median, over the rounds, of the
mean over the frames. PNG is included for comparison only; the server does not offer it.
"""

import io
import statistics
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt
from PIL import Image as Pillow

from arramon.v1.types_pb2 import ENCODING_JPEG, ENCODING_RAW, ENCODING_ZSTD, Encoding, Image
from arramon_client.transport.images import ImageDecoder
from arramon_server.api.encoding import MessageEncoder
from arramon_server.episodes.episode import Episode
from arramon_server.episodes.splits import read_splits
from arramon_server.runs.play.session import EpisodeSession
from arramon_server.sim.bullet import ReferenceCamera
from arramon_server.sim.cameras import Frame
from arramon_server.sim.city import city_scene
from arramon_server.sim.room_scene import room_scene
from arramon_server.sim.rules import Limits, State
from arramon_server.sim.view import view
from benchmarks.common import (
    add_json,
    add_rounds,
    data_or_sample,
    markdown_table,
    parser_of,
    positive_int,
    write_json,
)

SIZES = (224, 128)
LINK = 100.0
"""Bandwidth of the slow link, in kilobits per millisecond (megabits per second)."""

Pixels = npt.NDArray[Any]


@dataclass(frozen=True)
class ImageCodec:
    """An image encoding: functions to encode and decode, and the encoded size."""

    name: str
    encode: Callable[[Pixels], Any]
    decode: Callable[[Any], Pixels]
    size: Callable[[Any], int]


@dataclass
class EncodingCost:
    """Results of one encoding, on images of one kind and size."""

    image: str
    side: int
    encoding: str
    encode_us: float = 0.0
    decode_us: float = 0.0
    kilobytes: float = 0.0
    link_ms: float = 0.0
    rounds: list[tuple[float, float]] = field(default_factory=list)


def main() -> None:
    """Run the benchmark and print its table."""
    parser = parser_of(__doc__)
    parser.add_argument(
        "--frames", type=positive_int, default=24, help="number of frames of each size (default: %(default)s)"
    )
    add_rounds(parser, 9)
    add_json(parser)
    options = parser.parse_args()
    rows = []
    for side, frames in rendered(options.frames).items():
        rows += measured("rgb", side, [frame.rgb for frame in frames], colour_codecs(), options.rounds)
        rows += measured("depth", side, [frame.depth for frame in frames], depth_codecs(), options.rounds)
    print(table(rows))
    write_json(options.json, [asdict(row) for row in rows])


def rendered(count: int) -> dict[int, list[Frame]]:
    """Draw `count` frames of each size, evenly from all episodes and phases."""
    with data_or_sample(None) as data, ExitStack() as stack:
        (split,) = read_splits(data).values()
        cities = {
            name: stack.enter_context(ReferenceCamera(city_scene(section))) for name, section in split.sections.items()
        }
        room = stack.enter_context(ReferenceCamera(room_scene()))
        seen = [
            (episode, state)
            for episode in split.episodes.values()
            for state in _states(episode, cities[episode.section])
        ]
        chosen = [seen[round(i * (len(seen) - 1) / max(count - 1, 1))] for i in range(count)]
        frames: dict[int, list[Frame]] = {side: [] for side in SIZES}
        for episode, state in chosen:
            shown = view(state, episode.layout)
            world = room if shown.indoors else cities[episode.section]
            for side in SIZES:
                frames[side].append(world.render(shown.viewpoint, shown.actors, side))
    return frames


def _states(episode: Episode, ground: ReferenceCamera) -> list[State]:
    session = EpisodeSession(episode, ground, Limits(steps_per_phase=10_000))
    actions = [actions for turn in episode.turns for actions in (turn.actions, turn.room_actions)]
    return [before for phase in actions for before, _ in session.replay(phase)]


def colour_codecs() -> list[ImageCodec]:
    """Return the encodings of RGB."""
    return [
        _offered("raw", ENCODING_RAW),
        _offered("zstd", ENCODING_ZSTD),
        _offered("jpeg 90", ENCODING_JPEG, 90),
        _offered("jpeg 75", ENCODING_JPEG, 75),
        _png(),
    ]


def depth_codecs() -> list[ImageCodec]:
    """Return the encodings of depth."""
    return [_offered("raw", ENCODING_RAW, depth=True), _offered("zstd", ENCODING_ZSTD, depth=True), _png()]


def _offered(name: str, encoding: Encoding.ValueType, quality: int = 0, *, depth: bool = False) -> ImageCodec:
    encoder, decoder = MessageEncoder(encoding, quality), ImageDecoder()

    def encode(pixels: Pixels) -> Image:
        image = Image()
        (data,) = encoder.encode("", [(pixels, image)], latest=True)
        image.data = bytes(data)
        return image

    return ImageCodec(name, encode, decoder.depth if depth else decoder.rgb, lambda image: len(image.data))


def _png() -> ImageCodec:
    def encode(pixels: Pixels) -> bytes:
        file = io.BytesIO()
        Pillow.fromarray(pixels).save(file, "PNG", compress_level=1)
        return file.getvalue()

    return ImageCodec("(png)", encode, lambda data: np.asarray(Pillow.open(io.BytesIO(data))), len)


def measured(
    image: str, side: int, frames: Sequence[Pixels], codecs: Sequence[ImageCodec], rounds: int
) -> list[EncodingCost]:
    """Measure encodings in alternating rounds; return a row for each."""
    rows = [EncodingCost(image, side, codec.name) for codec in codecs]
    for number in range(rounds + 1):
        for codec, row in zip(codecs, rows, strict=True):
            started = time.perf_counter()
            encoded = [codec.encode(pixels) for pixels in frames]
            between = time.perf_counter()
            for each in encoded:
                codec.decode(each)
            ended = time.perf_counter()
            row.kilobytes = statistics.fmean(codec.size(each) for each in encoded) / 1000
            if number:  # The first round warms up.
                row.rounds.append(((between - started) / len(frames) * 1e6, (ended - between) / len(frames) * 1e6))
    for row in rows:
        row.encode_us, row.decode_us = map(statistics.median, zip(*row.rounds, strict=True))
        row.link_ms = row.kilobytes * 8 / LINK
    return rows


def table(rows: Sequence[EncodingCost]) -> str:
    """Return the rows as a Markdown table."""
    header = ("image", "encoding", "encode us", "decode us", "kB", f"ms at {LINK:.0f} Mbit/s")
    return markdown_table(
        header,
        [
            (
                f"{row.image} {row.side}", row.encoding, f"{row.encode_us:.0f}", f"{row.decode_us:.0f}",
                f"{row.kilobytes:.1f}", f"{row.link_ms:.2f}",
            )
            for row in rows
        ],
    )  # fmt: skip


if __name__ == "__main__":
    main()
