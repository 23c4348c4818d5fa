"""Decodes the images of the protocol into arrays."""

import threading

import numpy as np
import numpy.typing as npt
import simplejpeg
import zstandard

from arramon.v1 import types_pb2
from arramon_client.errors import ProtocolError

THOUSANDTHS = np.float32(0.001)
"""Depth travels as whole thousandths of a unit."""


def decode_rgb(image: types_pb2.Image, shared: memoryview | None = None) -> npt.NDArray[np.uint8]:
    """The picture as an array.

    Args:
        image: in any encoding of the protocol.
        shared: the memory that the server shares, where it does.

    Returns:
        (height, width, 3) uint8. But for JPEG it is read-only.

    Raises:
        ProtocolError: if the data is not what the message says it is.
    """
    shape = (image.height, image.width, 3)
    if image.encoding == types_pb2.ENCODING_JPEG:
        return _jpeg(image.data, shape)
    return np.frombuffer(_bytes(image, 3, shared), np.uint8).reshape(shape)


def decode_depth(image: types_pb2.Image, shared: memoryview | None = None) -> npt.NDArray[np.float32]:
    """The depth map as an array.

    Args:
        image: in any encoding of the protocol but JPEG.
        shared: the memory that the server shares, where it does.

    Returns:
        (height, width) float32, units ("metres") along the viewing direction; 0 where nothing was hit.

    Raises:
        ProtocolError: if the data is not what the message says it is.
    """
    metres = np.frombuffer(_bytes(image, 2, shared, copied=False), "<u2").astype(np.float32)
    metres *= THOUSANDTHS
    return metres.reshape(image.height, image.width)


def decode_segmentation(image: types_pb2.Image, shared: memoryview | None = None) -> npt.NDArray[np.uint16]:
    """The segmentation as an array.

    Args:
        image: in any encoding of the protocol but JPEG.
        shared: the memory that the server shares, where it does.

    Returns:
        (height, width) uint16, each pixel's place in the stream's labels; read-only.

    Raises:
        ProtocolError: if the data is not what the message says it is.
    """
    places = np.frombuffer(_bytes(image, 2, shared), "<u2").reshape(image.height, image.width)
    return places.astype(np.uint16, copy=False)


def _bytes(
    image: types_pb2.Image, bytes_a_pixel: int, shared: memoryview | None, *, copied: bool = True
) -> bytes | memoryview:
    """The pixels of an image that lost nothing, of exactly the length announced.

    Those in shared memory do not stay; they are copied unless the caller does.
    """
    expected = image.height * image.width * bytes_a_pixel
    if image.encoding == types_pb2.ENCODING_SHARED:
        pixels = _shared(image.place, expected, shared)
        return bytes(pixels) if copied else pixels
    data = image.data  # Once: each access copies it.
    if image.encoding == types_pb2.ENCODING_ZSTD:
        return _decompressed(data, expected)
    if image.encoding != types_pb2.ENCODING_RAW:
        raise ProtocolError(f"an image of {bytes_a_pixel} bytes a pixel came in the encoding {image.encoding}")
    if len(data) != expected:
        raise ProtocolError(f"a raw image of {image.height} x {image.width} has {len(data)} bytes, {expected} expected")
    return data


def _shared(place: int, expected: int, shared: memoryview | None) -> memoryview:
    if shared is None:
        raise ProtocolError("an image came in shared memory, and the server shares none")
    if place + expected > len(shared):
        raise ProtocolError(f"an image of {expected} bytes lies at {place} in shared memory of {len(shared)}")
    return shared[place : place + expected]


def _decompressed(data: bytes, expected: int) -> bytes:
    try:
        stated = zstandard.frame_content_size(data)
        if stated != expected:  # Before it is decompressed, which takes that much memory.
            size = "an unstated number of" if stated < 0 else stated
            raise ProtocolError(f"a compressed image has {size} bytes, {expected} expected")
        return _threads.decompressor.decompress(data, allow_extra_data=False)
    except zstandard.ZstdError as error:
        raise ProtocolError(f"an image that should be a Zstandard frame cannot be decoded: {error}") from error


def _jpeg(data: bytes, shape: tuple[int, int, int]) -> npt.NDArray[np.uint8]:
    try:
        height, width, *_ = simplejpeg.decode_jpeg_header(data)
        if (height, width) != shape[:2]:  # Before it is decoded, which takes that much memory.
            raise ProtocolError(f"an image of {shape[0]} x {shape[1]} was announced, but it is of {height} x {width}")
        pixels: npt.NDArray[np.uint8] = simplejpeg.decode_jpeg(data, colorspace="RGB")
    except ValueError as error:
        raise ProtocolError(f"an image that should be JPEG cannot be decoded: {error}") from error
    return pixels


class _Threads(threading.local):
    """A decompressor a thread: it must not be shared between two, and takes 15 microseconds to make."""

    def __init__(self) -> None:
        self.decompressor = zstandard.ZstdDecompressor()


_threads = _Threads()
