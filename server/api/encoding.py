"""The contract of image encoders, and the encoder into messages: raw, losslessly compressed, or JPEG.

The encodings are defined in `types.proto`. `shared_memory.py` holds the other encoder; `encoding_choice.py` chooses.
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
"""Pairs of pixels and the empty message for them. The pixels are not changed later."""

STANDARD_ENCODINGS = (ENCODING_RAW, ENCODING_ZSTD, ENCODING_JPEG)
"""Encodings that every server offers, in its order of preference."""

JPEG_QUALITY = 90
"""Quality if the client does not choose one."""

ZSTD = zstandard.ZstdCompressionParameters(
    strategy=zstandard.STRATEGY_FAST, window_log=18, hash_log=13, min_match=7, target_length=1
)
"""Quicker than level 1, to compress and to decompress, for images a sixth larger: matches are long in frames of flat
colours and repeated textures, so short ones are not looked for, and what is left is not worth an entropy code. Higher
levels gain next to nothing (benchmarks/serving/encodings.py)."""


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
        """Whether encoding is work for another thread; otherwise it only copies."""

    @property
    def form(self) -> str:
        """Quality of the images, on which an agent's score may depend: "lossless", or "jpeg" with its quality."""

    def announce(self, opened: Opened) -> None:
        """Write to a stream's first message what the client needs to decode the images."""

    def canvas(self, episode_id: str) -> Frame | None:
        """Return where an episode's latest observation is to be drawn, so that `encode` need not copy it.

        None if any place will do.
        """

    def encode(self, episode_id: str, images: Images, *, latest: bool) -> list[Data]:
        """Encode the images of one observation: write their empty messages, all but the data, and return the data.

        Args:
            episode_id: the observation's episode.
            images: pairs of pixels and message.
            latest: False for an observation of a history, which later ones of the same delivery follow.

        Returns:
            The data of each message; empty for images in shared memory. It may be a view of the pixels.
        """

    def forget(self, episode_id: str) -> None:
        """Free what is held for an episode that has ended."""

    def __enter__(self) -> Self:
        """Acquire what the stream needs."""

    def __exit__(self, *error: object) -> None:
        """Release it."""


class MessageEncoder:
    """Encodes images into the messages themselves: raw, Zstandard or JPEG.

    Args:
        encoding: of RGB images, one of `STANDARD_ENCODINGS`.
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
    def form(self) -> str:
        """Quality of the images: "lossless", or "jpeg" with its quality."""
        return f"jpeg{self.jpeg_quality}" if self.jpeg_quality else "lossless"

    def announce(self, opened: Opened) -> None:
        """Write the encoding to a stream's first message."""
        opened.encoding, opened.jpeg_quality = self.encoding, self.jpeg_quality

    def canvas(self, episode_id: str) -> Frame | None:  # noqa: ARG002, part of the contract
        """Return None: what is drawn is encoded into messages."""
        return None

    def encode(self, episode_id: str, images: Images, *, latest: bool) -> list[Data]:  # noqa: ARG002, part of the contract
        """Encode the images of one observation: write their empty messages, all but the data, and return the data."""
        return [self._encode(pixels, image) for pixels, image in images]

    def forget(self, episode_id: str) -> None:
        """Do nothing: no episode's images are held."""

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
        # No filter comes first (neighbour differences, byte planes): none makes these frames smaller. A level
        # camera sees walls as repeated rows, which the compressor handles best unfiltered.
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
    """One compressor for each thread: threads must not share one, and it takes 1 MB and 20 microseconds to create."""

    def __init__(self) -> None:
        self.compressor = zstandard.ZstdCompressor(compression_params=ZSTD)


_per_thread = _ThreadCompressor()
