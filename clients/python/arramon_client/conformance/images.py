"""Checks of images: every offered encoding decodes, lossless ones equal raw pixels, and sizes are as requested."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
import simplejpeg

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1 import types_pb2
from arramon_client.conformance.assertions import Skipped, expect, expect_equal, need
from arramon_client.conformance.suite import check
from arramon_client.conformance.target import Target
from arramon_client.transport.images import ImageDecoder, ImagesUnreadableError
from arramon_client.transport.shared_memory import decoder_of
from arramon_client.world import IMAGE_SENSORS

QUALITY = 95
"""JPEG quality requested."""

MAX_DIFFERENCE = 16.0
"""Maximum mean difference of a JPEG image's pixels from the raw ones, out of 255."""

Images = Mapping[str, npt.NDArray[Any]]


@check("images.raw", runs=1)
def raw(target: Target) -> None:
    """ENCODING_RAW sends exactly the pixels, in the requested size."""
    run = _run(target, types_pb2.ENCODING_RAW)
    _show(target, run, types_pb2.ENCODING_RAW, target.smallest())


@check("images.zstd", runs=1)
def zstd(target: Target) -> None:
    """ENCODING_ZSTD decodes to the same pixels as ENCODING_RAW."""
    _compare(target, types_pb2.ENCODING_ZSTD)


@check("images.shared", runs=1)
def shared(target: Target) -> None:
    """ENCODING_SHARED provides the same pixels as ENCODING_RAW, in memory that the server shares."""
    _compare(target, types_pb2.ENCODING_SHARED)


@check("images.jpeg", runs=1)
def jpeg(target: Target) -> None:
    """ENCODING_JPEG is a 4:2:0 JPEG of the same image in the requested quality; depth remains lossless."""
    _compare(target, types_pb2.ENCODING_JPEG)


@check("images.default", runs=1)
def default(target: Target) -> None:
    """A stream that requests no encoding and no size gets the server's first ones, which `opened` names."""
    run = _run(target, types_pb2.ENCODING_UNSPECIFIED)
    expected = target.info.encodings[0], target.info.image_sizes[0]
    with target.play(run) as stream:
        opened, _, seen = stream.begin()
        expect_equal("encoding and size in `opened`", (opened.encoding, opened.image_size), expected)
        expect(
            set(run.sensors) <= set(IMAGE_SENSORS),
            f"the run has the sensors {list(run.sensors)}, expected images alone",
        )
        for name in run.sensors:
            image = getattr(seen, name)
            expect_equal(f"the size of {name}", (image.height, image.width), (expected[1], expected[1]))


@check("images.sizes", runs=1)
def sizes(target: Target) -> None:
    """Every offered image size is served."""
    run = _run(target, types_pb2.ENCODING_UNSPECIFIED)
    for size in target.info.image_sizes:
        _show(target, run, types_pb2.ENCODING_UNSPECIFIED, size)


def _run(target: Target, encoding: types_pb2.Encoding.ValueType) -> pb.Run:
    """Create a run with images.

    Raises:
        Skipped: if the server does not offer the encoding, or the split offers no images.
    """
    name = types_pb2.Encoding.Name(encoding)
    offered = encoding in (*target.info.encodings, types_pb2.ENCODING_UNSPECIFIED)
    where = ", as on a Unix socket on Linux," if encoding == types_pb2.ENCODING_SHARED else ""
    need(offered, f"the server does not offer {name}; an address where it does{where} would make it run")
    names = [sensor for sensor in ("rgb", "depth") if sensor in target.split.sensors]
    need(names, f"the split {target.split.name!r} offers neither rgb nor depth; one that does would make it run")
    return target.create(sensors=names)


def _compare(target: Target, encoding: types_pb2.Encoding.ValueType) -> None:
    """Check that an encoding's images equal the raw pixels, or are similar in the case of RGB as JPEG."""
    run = _run(target, encoding)
    shown = _show(target, run, encoding, target.smallest())
    if types_pb2.ENCODING_RAW not in target.info.encodings:
        raise Skipped("it decodes, but the server does not offer ENCODING_RAW to compare it with; one that does would")
    for name, pixels in _show(target, run, types_pb2.ENCODING_RAW, target.smallest()).items():
        if name == "rgb" and encoding == types_pb2.ENCODING_JPEG:
            difference = float(np.abs(pixels.astype(int) - shown[name].astype(int)).mean())
            found = f"pixels differ from raw ones by {difference:.1f} of 255 in the mean"
            expect(difference <= MAX_DIFFERENCE, f"{found}, expected at most {MAX_DIFFERENCE:g}")
        else:
            wrong = int((pixels != shown[name]).sum())
            expect(not wrong, f"{wrong} values of {name} differ from those of ENCODING_RAW, expected none")


def _show(target: Target, run: pb.Run, encoding: types_pb2.Encoding.ValueType, size: int) -> Images:
    """Open a stream on a run, and return the decoded images of its first observation."""
    quality = QUALITY if encoding == types_pb2.ENCODING_JPEG else 0
    asked = {"encoding": encoding, "image_size": size, "jpeg_quality": quality}
    with target.play(run, player="conformance", **asked) as stream:
        opened, _, seen = stream.begin()
        in_force = encoding or target.info.encodings[0]
        expect_equal("the encoding in `opened`", opened.encoding, in_force)
        expect_equal("the image size in `opened`", opened.image_size, size)
        if quality:
            expect_equal("the JPEG quality in `opened`", opened.jpeg_quality, quality)
        decoder = _decoder(opened)
        images: dict[str, npt.NDArray[Any]] = {}
        expect(
            set(run.sensors) <= set(IMAGE_SENSORS),
            f"the run has the sensors {list(run.sensors)}, expected images alone",
        )
        for name in run.sensors:
            image = getattr(seen, name)
            expect_equal(f"the size of {name}", (image.height, image.width), (size, size))
            lossless = types_pb2.ENCODING_ZSTD if in_force == types_pb2.ENCODING_JPEG else in_force
            own = in_force if name == "rgb" else lossless
            expect_equal(f"the encoding of {name}", image.encoding, own)
            if own == types_pb2.ENCODING_JPEG:
                expect_equal("the JPEG's chroma", simplejpeg.decode_jpeg_header(image.data)[3], "420")
            images[name] = getattr(decoder, name)(image)
    return images


def _decoder(opened: pb.Opened) -> ImageDecoder:
    try:
        return decoder_of(opened)
    except ImagesUnreadableError as error:
        raise Skipped(f"{error}; the suite on the server's machine, as the same user, would make it run") from error


CHECKS = (raw, zstd, shared, jpeg, default, sizes)
