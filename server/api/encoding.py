"""How images travel in messages: raw, compressed without loss, or as JPEG, as `types.proto` has it."""

import threading

import numpy as np
import numpy.typing as npt
import simplejpeg
import zstandard

from arramon.v1.types_pb2 import ENCODING_JPEG, ENCODING_RAW, ENCODING_SHARED, ENCODING_ZSTD, Encoding, Image
from server.errors import BadInput

OFFERED = (ENCODING_RAW, ENCODING_ZSTD, ENCODING_JPEG)
"""Everywhere, in the server's order of preference."""

JPEG_QUALITY = 90
"""For a client that does not choose."""

ZSTD_LEVEL = 1
"""Higher ones gain next to nothing: frames are flat colours and repeated textures (benchmarks/encodings.py)."""


class Encoder:
    """Encodes the images of one stream.

    Args:
        encoding: of RGB images; ENCODING_UNSPECIFIED for the first offered. With ENCODING_SHARED, which is for those
            that travel in memory, this encodes the others, raw.
        jpeg_quality: 1 to 100 where `encoding` is JPEG, or 0 for `JPEG_QUALITY`.
        offered: what may be asked for.

    Raises:
        BadInput: if the encoding is not offered, or the quality is out of range or given for another encoding.

    Attributes:
        encoding: in force.
        jpeg_quality: in force; 0 where the encoding has none.
    """

    def __init__(
        self,
        encoding: Encoding.ValueType,
        jpeg_quality: int = 0,
        offered: tuple[Encoding.ValueType, ...] = OFFERED,
    ) -> None:
        self.encoding = encoding or offered[0]
        if self.encoding not in offered:
            raise BadInput(f"encoding {self.encoding} is not offered; see ServerInfo.encodings")
        if jpeg_quality and self.encoding != ENCODING_JPEG:
            name = Encoding.Name(self.encoding)
            raise BadInput(f"jpeg_quality is {jpeg_quality}, but the encoding is {name}: it is for ENCODING_JPEG only")
        if jpeg_quality > 100:
            raise BadInput(f"jpeg_quality is {jpeg_quality}, expected 1 to 100, or 0 for {JPEG_QUALITY}")
        self._lossless = ENCODING_RAW if self.encoding in (ENCODING_RAW, ENCODING_SHARED) else ENCODING_ZSTD
        self.jpeg_quality = (jpeg_quality or JPEG_QUALITY) if self.encoding == ENCODING_JPEG else 0

    @property
    def form(self) -> str:
        """What an agent's score may depend on: "lossless", or "jpeg" with its quality."""
        return f"jpeg{self.jpeg_quality}" if self.jpeg_quality else "lossless"

    def write(self, pixels: npt.NDArray[np.uint8] | npt.NDArray[np.uint16], image: Image) -> None:
        """Writes an image of either kind into an empty message: RGB has three dimensions."""
        if pixels.ndim == 3:
            self.rgb(pixels.astype(np.uint8, copy=False), image)
        else:
            self.numbers(pixels.astype(np.uint16, copy=False), image)

    def rgb(self, pixels: npt.NDArray[np.uint8], image: Image) -> None:
        """Writes a (height, width, 3) uint8 image into an empty message: in place, which saves a copy."""
        if self.encoding != ENCODING_JPEG:
            self._raw_or_zstd(pixels, image)
            return
        image.height, image.width = pixels.shape[:2]
        image.encoding = ENCODING_JPEG
        image.data = simplejpeg.encode_jpeg(
            np.ascontiguousarray(pixels), quality=self.jpeg_quality, colorspace="RGB", colorsubsampling="420"
        )

    def numbers(self, pixels: npt.NDArray[np.uint16], image: Image) -> None:
        """Writes a (height, width) uint16 depth map or segmentation into an empty message: never lossy."""
        self._raw_or_zstd(pixels.astype("<u2", copy=False), image)

    def _raw_or_zstd(self, pixels: npt.NDArray[np.uint8] | npt.NDArray[np.uint16], image: Image) -> None:
        image.height, image.width = pixels.shape[:2]
        image.encoding = self._lossless
        if self._lossless == ENCODING_RAW:
            image.data = pixels.tobytes()
        else:
            # No filter goes before it (differences of neighbours, bytes apart): none makes these frames smaller. A
            # level camera sees walls as rows that repeat, which the compressor finds best as they are.
            image.data = _threads.compressor.compress(np.ascontiguousarray(pixels).data)


class _Threads(threading.local):
    """A compressor a thread: it must not be shared between two, takes a megabyte, and 20 microseconds to make."""

    def __init__(self) -> None:
        self.compressor = zstandard.ZstdCompressor(level=ZSTD_LEVEL)


_threads = _Threads()
