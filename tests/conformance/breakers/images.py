"""Faults in sensors and images."""

from collections.abc import Callable

import numpy as np
import simplejpeg
import zstandard

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1 import types_pb2
from tests.conformance.breakers.faults import clears, events, opens, sets


def black_zstd(seen: pb.Observation) -> None:
    if seen.rgb.encoding == types_pb2.ENCODING_ZSTD:
        seen.rgb.data = zstandard.compress(bytes(seen.rgb.height * seen.rgb.width * 3))


def jpeg(subsampling: str, value: int) -> Callable[[pb.Observation], None]:
    def change(seen: pb.Observation) -> None:
        if seen.rgb.encoding == types_pb2.ENCODING_JPEG:
            pixels = np.full((seen.rgb.height, seen.rgb.width, 3), value, np.uint8)
            seen.rgb.data = simplejpeg.encode_jpeg(pixels, colorspace="RGB", colorsubsampling=subsampling)

    return change


def one_label(opened: pb.Opened) -> None:
    del opened.labels[1:]


def misplaced(seen: pb.Observation) -> None:
    if seen.rgb.encoding == types_pb2.ENCODING_SHARED:
        seen.rgb.place = 0


IMAGES = [
    (
        "sensors.asked",
        events("observation", lambda seen: seen.pose.SetInParent()),
        "the list of sensors .* is .'pose'.",
    ),
    (
        "sensors.asked",
        events("observation", clears("depth")),
        r"the list of sensors in the observation is \['rgb', 'seg",
    ),
    ("sensors.asked", events("episode_started", lambda s: s.oracle.SetInParent()), "came with the oracle"),
    ("sensors.asked", events("opened", clears("labels")), "whether `opened` has labels is False, expected True"),
    ("sensors.oracle", events("episode_started", clears("oracle")), "the episode came without the oracle"),
    ("sensors.oracle", events("episode_started", lambda s: s.oracle.targets.pop()), "the number of targets is 1"),
    (
        "sensors.segmentation",
        events("opened", one_label),
        "a pixel has the number .*, expected",
    ),
    (
        "sensors.segmentation",
        events("opened", lambda first: sets(kind="")(first.labels[1])),
        "a label has no kind",
    ),
    ("images.raw", events("observation", lambda seen: sets(data=b"short")(seen.rgb)), "has 5 bytes, expected 49152"),
    (
        "images.raw",
        events("opened", sets(encoding=types_pb2.ENCODING_ZSTD)),
        "the encoding in `opened` is 2, expected 1",
    ),
    ("images.zstd", events("observation", black_zstd), r"\d+ values of rgb differ from those of ENCODING_RAW"),
    (
        "images.zstd",
        events("observation", lambda seen: sets(data=b"?")(seen.depth)),
        "a Zstandard image cannot be decoded",
    ),
    ("images.shared", events("observation", misplaced), r"\d+ values of rgb differ from those of ENCODING_RAW"),
    ("images.jpeg", events("observation", jpeg("444", 0)), "the JPEG's chroma is '444', expected '420'"),
    ("images.jpeg", events("observation", jpeg("420", 0)), "pixels differ from raw ones by"),
    ("images.jpeg", events("opened", sets(jpeg_quality=1)), "the JPEG quality in `opened` is 1, expected 95"),
    ("images.default", events("opened", sets(image_size=1)), r"encoding and size in `opened` is \(1, 1\)"),
    ("images.sizes", opens(image_size=0), "the image size in `opened` is 224, expected 128"),
]
