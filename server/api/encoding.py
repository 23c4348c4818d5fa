"""The interface of image encoders, and the encoder that puts images into messages: raw, lossless or JPEG.

`types.proto` defines the encodings. `shared_memory.py` has the other encoder; `encoding_choice.py` selects one.
"""

import threading
from collections.abc import Iterable
from typing import Protocol, Self

import numpy as np
import numpy.typing as npt
import simplejpeg
import zstandard

from arramon.v1.evaluation_pb2 import Opened
from arramon.v1.types_pb2 import ENCODING_JPEG, ENCODING_RAW, ENCODING_ZSTD, Encoding, Image
from arramon_server.api.wire import Data
from arramon_server.errors import BadInput
from arramon_server.sim.cameras import Frame

Pixels = npt.NDArray[np.uint8] | npt.NDArray[np.uint16]
"""(height, width, 3) uint8 for RGB; (height, width) uint16 for depth and segmentation."""

Images = Iterable[tuple[Pixels, Image]]
"""Pairs of pixels and an empty message for them. The pixels are not modified later."""

STANDARD_ENCODINGS = (ENCODING_RAW, ENCODING_ZSTD, ENCODING_JPEG)
"""Encodings that every server offers, in order of preference."""

JPEG_QUALITY = 90
"""JPEG quality if the client does not choose one."""

ZSTD = zstandard.ZstdCompressionParameters(
    strategy=zstandard.STRATEGY_FAST, window_log=18, hash_log=13, min_match=7, target_length=1
)
"""Faster than level 1 in both directions, with images one sixth larger. Frames of flat colours and repeated textures
have long matches, so short matches and entropy coding of literals are skipped. Higher levels save next to nothing
(benchmarks/serving/encodings.py)."""


class ImageEncoder(Protocol):
    """Encodes the images of one stream, as a context manager around its messages.

    Attributes:
        encoding: the encoding in use.
        jpeg_quality: the quality in use; 0 if the encoding is not JPEG.
    """

    encoding: Encoding.ValueType
    jpeg_quality: int

    @property
    def compresses(self) -> bool:
        """Whether encoding compresses, and should run in another thread; otherwise it only copies."""

    @property
    def image_quality(self) -> str:
        """Quality of the images, which may affect an agent's score: "lossless", or "jpeg" followed by its quality."""

    def announce(self, opened: Opened) -> None:
        """Add to a stream's first message what the client needs to decode the images."""

    def canvas(self, episode_id: str) -> Frame | None:
        """Return the buffer for drawing an episode's latest observation, which `encode` then need not copy.

        None if the images may be drawn anywhere.
        """

    def encode(self, episode_id: str, images: Images, *, latest: bool) -> list[Data]:
        """Encode the images of one observation: fill in their messages except the data, and return the data.

        Args:
            episode_id: id of the observation's episode.
            images: pairs of pixels and empty message.
            latest: False for an observation of a history, which is followed by later ones in the same delivery.

        Returns:
            The data for each message; empty for images in shared memory. It may be a view of the pixels.
        """

    def forget(self, episode_id: str) -> None:
        """Free the memory of an episode that has ended."""

    def __enter__(self) -> Self:
        """Acquire the resources of the stream."""

    def __exit__(self, *error: object) -> None:
        """Release the resources of the stream."""


class MessageEncoder:
    """Encodes images into the messages themselves: raw, Zstandard or JPEG.

    Args:
        encoding: encoding of RGB images, one of `STANDARD_ENCODINGS`.
        jpeg_quality: 1 to 100 if `encoding` is ENCODING_JPEG, or 0 for `JPEG_QUALITY`.

    Raises:
        BadInput: if the quality is out of range or given for another encoding.
    """

    def __init__(self, encoding: Encoding.ValueType, jpeg_quality: int = 0) -> None:
        self.encoding = encoding
        check_quality(encoding, jpeg_quality)
        self._lossless = ENCODING_RAW if encoding == ENCODING_RAW else ENCODING_ZSTD
        self.jpeg_quality = (jpeg_quality or JPEG_QUALITY) if encoding == ENCODING_JPEG else 0

    @property
    def compresses(self) -> bool:
        """Whether the images are compressed."""
        return self.encoding != ENCODING_RAW

    @property
    def image_quality(self) -> str:
        """Quality of the images: "lossless", or "jpeg" with its quality."""
        return f"jpeg{self.jpeg_quality}" if self.jpeg_quality else "lossless"

    def announce(self, opened: Opened) -> None:
        """Add the encoding to a stream's first message."""
        opened.encoding, opened.jpeg_quality = self.encoding, self.jpeg_quality

    def canvas(self, episode_id: str) -> Frame | None:  # noqa: ARG002, part of the contract
        """Return None: images may be drawn anywhere, and are encoded into messages."""
        return None

    def encode(self, episode_id: str, images: Images, *, latest: bool) -> list[Data]:  # noqa: ARG002, part of the contract
        """Encode the images of one observation: fill in their messages except the data, and return the data."""
        return [self._encode(pixels, image) for pixels, image in images]

    def forget(self, episode_id: str) -> None:
        """Do nothing: no memory is held for episodes."""

    def __enter__(self) -> Self:
        """Do nothing."""
        return self

    def __exit__(self, *error: object) -> None:
        """Do nothing."""

    def _encode(self, pixels: Pixels, image: Image) -> Data:
        image.height, image.width = pixels.shape[:2]
        contiguous = np.ascontiguousarray(little_endian(pixels))
        if pixels.ndim == 3 and self.encoding == ENCODING_JPEG:
            image.encoding = ENCODING_JPEG
            jpeg: bytes = simplejpeg.encode_jpeg(
                contiguous, quality=self.jpeg_quality, colorspace="RGB", colorsubsampling="420"
            )
            return jpeg
        image.encoding = self._lossless
        content = contiguous.reshape(-1).view(np.uint8).data
        if self._lossless == ENCODING_RAW:
            return content
        # No filter is applied first (neighbour differences, byte planes): none makes these frames smaller. A level
        # camera sees walls as repeated rows, which compress best unfiltered.
        return _per_thread.compressor.compress(content)


def check_quality(encoding: Encoding.ValueType, jpeg_quality: int) -> None:
    """Raise BadInput if the JPEG quality is out of range, or given for another encoding."""
    if jpeg_quality and encoding != ENCODING_JPEG:
        name = Encoding.Name(encoding)
        raise BadInput(f"jpeg_quality is {jpeg_quality}, expected 0 with {name}: only ENCODING_JPEG has a quality")
    if jpeg_quality > 100:
        raise BadInput(f"jpeg_quality is {jpeg_quality}, expected 1 to 100, or 0 for {JPEG_QUALITY}")


def little_endian(pixels: Pixels) -> Pixels:
    """Return pixels in the byte order of the protocol."""
    return pixels.astype("<u2", copy=False) if pixels.dtype.itemsize == 2 else pixels


class _ThreadCompressor(threading.local):
    """One compressor per thread: threads must not share one, and each takes 1 MB and 20 microseconds to create."""

    def __init__(self) -> None:
        self.compressor = zstandard.ZstdCompressor(compression_params=ZSTD)


_per_thread = _ThreadCompressor()
