"""Encoding of images for messages: raw, losslessly compressed, or JPEG, as defined in `types.proto`."""

import threading

import numpy as np
import numpy.typing as npt
import simplejpeg
import zstandard

from arramon.v1.types_pb2 import ENCODING_JPEG, ENCODING_RAW, ENCODING_SHARED, ENCODING_ZSTD, Encoding, Image
from server.errors import BadInput

STANDARD_ENCODINGS = (ENCODING_RAW, ENCODING_ZSTD, ENCODING_JPEG)
"""Encodings that every server offers, in its order of preference."""

JPEG_QUALITY = 90
"""Quality if the client does not choose one."""

ZSTD_LEVEL = 1
"""Higher levels gain next to nothing: frames are flat colours and repeated textures (benchmarks/encodings.py)."""


class Encoder:
    """Encodes the images of one stream.

    Args:
        encoding: of RGB images; ENCODING_UNSPECIFIED for the first one offered. With ENCODING_SHARED, this encodes the
            images that do not go through shared memory, as ENCODING_RAW.
        jpeg_quality: 1 to 100 if `encoding` is ENCODING_JPEG, or 0 for `JPEG_QUALITY`.
        offered: encodings that a client may choose.

    Raises:
        BadInput: if the encoding is not offered, or the quality is out of range or given for another encoding.

    Attributes:
        encoding: the encoding in use.
        jpeg_quality: the quality in use; 0 if the encoding is not JPEG.
    """

    def __init__(
        self,
        encoding: Encoding.ValueType,
        jpeg_quality: int = 0,
        offered: tuple[Encoding.ValueType, ...] = STANDARD_ENCODINGS,
    ) -> None:
        self.encoding = encoding or offered[0]
        if self.encoding not in offered:
            raise BadInput(f"encoding {self.encoding} is not offered; see ServerInfo.encodings")
        if jpeg_quality and self.encoding != ENCODING_JPEG:
            name = Encoding.Name(self.encoding)
            raise BadInput(f"jpeg_quality is {jpeg_quality}, expected 0 with {name}: only ENCODING_JPEG has a quality")
        if jpeg_quality > 100:
            raise BadInput(f"jpeg_quality is {jpeg_quality}, expected 1 to 100, or 0 for {JPEG_QUALITY}")
        self._lossless = ENCODING_RAW if self.encoding in (ENCODING_RAW, ENCODING_SHARED) else ENCODING_ZSTD
        self.jpeg_quality = (jpeg_quality or JPEG_QUALITY) if self.encoding == ENCODING_JPEG else 0

    @property
    def form(self) -> str:
        """Quality of the images, on which an agent's score may depend: "lossless", or "jpeg" with its quality."""
        return f"jpeg{self.jpeg_quality}" if self.jpeg_quality else "lossless"

    def write(self, pixels: npt.NDArray[np.uint8] | npt.NDArray[np.uint16], image: Image) -> None:
        """Write an image into an empty message: (height, width, 3) is RGB, (height, width) depth or segmentation."""
        if pixels.ndim == 3:
            self.write_rgb(pixels.astype(np.uint8, copy=False), image)
        else:
            self.write_numbers(pixels.astype(np.uint16, copy=False), image)

    def write_rgb(self, pixels: npt.NDArray[np.uint8], image: Image) -> None:
        """Write a (height, width, 3) uint8 image into an empty message, in place, which saves a copy."""
        if self.encoding != ENCODING_JPEG:
            self._raw_or_zstd(pixels, image)
            return
        image.height, image.width = pixels.shape[:2]
        image.encoding = ENCODING_JPEG
        image.data = simplejpeg.encode_jpeg(
            np.ascontiguousarray(pixels), quality=self.jpeg_quality, colorspace="RGB", colorsubsampling="420"
        )

    def write_numbers(self, pixels: npt.NDArray[np.uint16], image: Image) -> None:
        """Write a (height, width) uint16 depth map or segmentation into an empty message, always losslessly."""
        self._raw_or_zstd(pixels.astype("<u2", copy=False), image)

    def _raw_or_zstd(self, pixels: npt.NDArray[np.uint8] | npt.NDArray[np.uint16], image: Image) -> None:
        image.height, image.width = pixels.shape[:2]
        image.encoding = self._lossless
        if self._lossless == ENCODING_RAW:
            image.data = pixels.tobytes()
        else:
            # No filter comes first (neighbour differences, byte planes): none makes these frames smaller. A level
            # camera sees walls as repeated rows, which the compressor handles best unfiltered.
            image.data = _threads.compressor.compress(np.ascontiguousarray(pixels).data)


class _Threads(threading.local):
    """One compressor for each thread: threads must not share one, and it takes 1 MB and 20 microseconds to create."""

    def __init__(self) -> None:
        self.compressor = zstandard.ZstdCompressor(level=ZSTD_LEVEL)


_threads = _Threads()
