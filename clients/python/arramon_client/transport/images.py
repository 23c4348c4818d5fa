"""Decoding of the protocol's images into arrays."""

import threading
from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np
import numpy.typing as npt
import simplejpeg
import zstandard

from arramon.v1 import types_pb2
from arramon_client.errors import ProtocolError
from arramon_client.transport.incoming import MAX_SIDE
from arramon_client.world import DEPTH_UNIT

THOUSANDTHS = np.float32(DEPTH_UNIT)
"""Factor from the protocol's depth values, whole thousandths of a unit, to units."""

_SEQUENTIAL = frozenset((0xC0, 0xC1))
"""JPEG markers of sequential frames, whose components are each decoded in one pass."""

_OTHER_FRAMES = frozenset(range(0xC2, 0xD0)) - {0xC4, 0xC8, 0xCC}
"""JPEG markers of all other frames: progressive, hierarchical or lossless."""

_BARE = frozenset((0x01, *range(0xD0, 0xD8)))
"""JPEG markers without a segment."""

_WITH_LENGTH = frozenset((0xC4, 0xCC, 0xDB, 0xDD, *range(0xE0, 0xF0), 0xFE))
"""JPEG markers of tables, comments and application data: segments that begin with their length."""

_SCAN, _MAX_SCANS = b"\xff\xda", 4
"""Marker of a pass, which compressed data never contain, and the maximum number of passes, one for each component."""

PixelReader = Callable[[types_pb2.Image, int], bytes | memoryview]
"""Function that returns a lossless image's pixels, exactly as many bytes as given, or raises ProtocolError."""


class ImagesUnreadableError(Exception):
    """The images of a stream cannot be read by this client in the requested encoding; another one works."""


class ImageDecoder:
    """Decodes the images of one stream.

    Args:
        readers: functions that read lossless images in further encodings, by encoding; the returned memory may change
            later.
    """

    def __init__(self, readers: Mapping[int, PixelReader] = MappingProxyType({})) -> None:
        self._readers = {types_pb2.ENCODING_RAW: _raw, types_pb2.ENCODING_ZSTD: _decompressed, **readers}

    def rgb(self, image: types_pb2.Image) -> npt.NDArray[np.uint8]:
        """Decode an RGB image, in any encoding of the stream.

        Returns:
            (height, width, 3) uint8, read-only.

        Raises:
            ProtocolError: if the data does not match the message's encoding and size.
        """
        shape = (image.height, image.width, 3)
        _check_sides(image)
        if image.encoding == types_pb2.ENCODING_JPEG:
            return _jpeg(image.data, shape)
        return np.frombuffer(bytes(self._pixels(image, 3)), np.uint8).reshape(shape)

    def depth(self, image: types_pb2.Image) -> npt.NDArray[np.float32]:
        """Decode a depth map, in any encoding of the stream except JPEG.

        Returns:
            (height, width) float32, units ("metres") along the viewing direction; 0 where nothing was hit; read-only.

        Raises:
            ProtocolError: if the data does not match the message's encoding and size.
        """
        metres = np.frombuffer(self._pixels(image, 2), "<u2").astype(np.float32)
        metres *= THOUSANDTHS
        metres.flags.writeable = False
        return metres.reshape(image.height, image.width)

    def segmentation(self, image: types_pb2.Image) -> npt.NDArray[np.uint16]:
        """Decode a segmentation, in any encoding of the stream except JPEG.

        Returns:
            (height, width) uint16, each pixel's index in the stream's labels; read-only.

        Raises:
            ProtocolError: if the data does not match the message's encoding and size.
        """
        places = np.frombuffer(bytes(self._pixels(image, 2)), "<u2").reshape(image.height, image.width)
        return places.astype(np.uint16, copy=False)

    def _pixels(self, image: types_pb2.Image, bytes_a_pixel: int) -> bytes | memoryview:
        """Return the pixels of a lossless image, of exactly the expected length; they may change later."""
        _check_sides(image)
        reader = self._readers.get(image.encoding)
        if reader is None:
            raise ProtocolError(f"an image with {bytes_a_pixel} bytes per pixel has the encoding {image.encoding}")
        return reader(image, image.height * image.width * bytes_a_pixel)


def _check_sides(image: types_pb2.Image) -> None:
    if not (0 < image.height <= MAX_SIDE and 0 < image.width <= MAX_SIDE):
        raise ProtocolError(f"an image is {image.height} x {image.width}, expected sides of 1 to {MAX_SIDE} pixels")


def _check_compressed(data: bytes, pixels: int) -> None:
    """Check that compressed data is not much larger than the image, as decoding it could take very long."""
    if len(data) > 2 * pixels + 4096:
        raise ProtocolError(f"a compressed image of {pixels} bytes takes {len(data)}")


def _raw(image: types_pb2.Image, expected: int) -> bytes:
    data = image.data  # Accessed only once: each access copies it.
    if len(data) != expected:
        raise ProtocolError(f"a raw image of {image.height} x {image.width} has {len(data)} bytes, expected {expected}")
    return data


def _decompressed(image: types_pb2.Image, expected: int) -> bytes:
    data = image.data
    _check_compressed(data, expected)
    try:
        stated = zstandard.frame_content_size(data)
        if stated != expected:  # Checked before decompression, which allocates that much memory.
            size = "an unstated number of" if stated < 0 else stated
            raise ProtocolError(f"a compressed image has {size} bytes, expected {expected}")
        return _thread_locals.decompressor.decompress(data, allow_extra_data=False)
    except zstandard.ZstdError as error:
        raise ProtocolError(f"a Zstandard image cannot be decoded: {error}") from error


def _jpeg(data: bytes, shape: tuple[int, int, int]) -> npt.NDArray[np.uint8]:
    height, width, channels = shape
    _check_compressed(data, height * width * channels)
    _check_sequential(data)
    try:
        height, width, *_ = simplejpeg.decode_jpeg_header(data)
        if (height, width) != shape[:2]:  # Checked before decoding, which allocates that much memory.
            raise ProtocolError(f"a JPEG image is {height} x {width}, expected {shape[0]} x {shape[1]}")
        pixels: npt.NDArray[np.uint8] = simplejpeg.decode_jpeg(data, colorspace="RGB")
        pixels.flags.writeable = False
    except ValueError as error:
        raise ProtocolError(f"a JPEG image cannot be decoded: {error}") from error
    return pixels


def _check_sequential(data: bytes) -> None:
    """Check that decoding a JPEG takes few passes over the image; many can take minutes.

    Only segments whose ends every decoder finds in the same place are skipped on the way to the frame's header.

    Raises:
        ProtocolError: if the JPEG is progressive, has too many passes, or has no frame header.
    """
    place = 2
    while place + 4 <= len(data) and data[place] == 0xFF:
        marker = data[place + 1]
        length = int.from_bytes(data[place + 2 : place + 4], "big")
        if marker in _SEQUENTIAL:
            scans = data.count(_SCAN)
            if scans > _MAX_SCANS:
                raise ProtocolError(f"a JPEG image has {scans} passes, expected at most {_MAX_SCANS}")
            return
        if marker in _OTHER_FRAMES:
            raise ProtocolError("a JPEG image is progressive, expected a sequential one")
        if marker == 0xFF:  # padding
            place += 1
        elif marker in _BARE:
            place += 2
        elif marker in _WITH_LENGTH and length >= 2:
            place += 2 + length
        else:
            break
    raise ProtocolError("a JPEG image cannot be decoded: it has no header of a sequential frame")


class _ThreadLocals(threading.local):
    """One decompressor per thread: threads must not share one, and creating one takes 15 microseconds."""

    def __init__(self) -> None:
        self.decompressor = zstandard.ZstdDecompressor()


_thread_locals = _ThreadLocals()
