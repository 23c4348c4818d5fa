"""Decoding of the protocol's images into arrays."""

import threading

import numpy as np
import numpy.typing as npt
import simplejpeg
import zstandard

from arramon.v1 import types_pb2
from arramon_client.errors import ProtocolError

THOUSANDTHS = np.float32(0.001)
"""Factor from the protocol's depth values, whole thousandths of a unit, to units."""


def decode_rgb(image: types_pb2.Image, shared: memoryview | None = None) -> npt.NDArray[np.uint8]:
    """Decode an RGB image.

    Args:
        image: an image in any encoding of the protocol.
        shared: the memory shared by the server, if any.

    Returns:
        (height, width, 3) uint8, read-only.

    Raises:
        ProtocolError: if the data does not match the message's encoding and size.
    """
    shape = (image.height, image.width, 3)
    if image.encoding == types_pb2.ENCODING_JPEG:
        return _jpeg(image.data, shape)
    return np.frombuffer(_bytes(image, 3, shared), np.uint8).reshape(shape)


def decode_depth(image: types_pb2.Image, shared: memoryview | None = None) -> npt.NDArray[np.float32]:
    """Decode a depth map.

    Args:
        image: an image in any encoding of the protocol except JPEG.
        shared: the memory shared by the server, if any.

    Returns:
        (height, width) float32, units ("metres") along the viewing direction; 0 where nothing was hit; read-only.

    Raises:
        ProtocolError: if the data does not match the message's encoding and size.
    """
    metres = np.frombuffer(_bytes(image, 2, shared, copied=False), "<u2").astype(np.float32)
    metres *= THOUSANDTHS
    metres.flags.writeable = False
    return metres.reshape(image.height, image.width)


def decode_segmentation(image: types_pb2.Image, shared: memoryview | None = None) -> npt.NDArray[np.uint16]:
    """Decode a segmentation.

    Args:
        image: an image in any encoding of the protocol except JPEG.
        shared: the memory shared by the server, if any.

    Returns:
        (height, width) uint16, each pixel's index in the stream's labels; read-only.

    Raises:
        ProtocolError: if the data does not match the message's encoding and size.
    """
    places = np.frombuffer(_bytes(image, 2, shared), "<u2").reshape(image.height, image.width)
    return places.astype(np.uint16, copy=False)


def _bytes(
    image: types_pb2.Image, bytes_a_pixel: int, shared: memoryview | None, *, copied: bool = True
) -> bytes | memoryview:
    """Return the pixels of a lossless image, of exactly the expected length.

    Shared memory is overwritten later, so pixels in it are copied unless `copied` is False and the caller copies them.
    """
    expected = image.height * image.width * bytes_a_pixel
    if image.encoding == types_pb2.ENCODING_SHARED:
        pixels = _shared(image.place, expected, shared)
        return bytes(pixels) if copied else pixels
    data = image.data  # Accessed only once: each access copies it.
    if image.encoding == types_pb2.ENCODING_ZSTD:
        return _decompressed(data, expected)
    if image.encoding != types_pb2.ENCODING_RAW:
        raise ProtocolError(f"an image with {bytes_a_pixel} bytes per pixel has the encoding {image.encoding}")
    if len(data) != expected:
        raise ProtocolError(f"a raw image of {image.height} x {image.width} has {len(data)} bytes, expected {expected}")
    return data


def _shared(place: int, expected: int, shared: memoryview | None) -> memoryview:
    if shared is None:
        raise ProtocolError("an image is in shared memory, but the server shares none")
    if place + expected > len(shared):
        raise ProtocolError(f"an image of {expected} bytes at {place} is outside the shared memory of {len(shared)}")
    return shared[place : place + expected]


def _decompressed(data: bytes, expected: int) -> bytes:
    try:
        stated = zstandard.frame_content_size(data)
        if stated != expected:  # Checked before decompression, which allocates that much memory.
            size = "an unstated number of" if stated < 0 else stated
            raise ProtocolError(f"a compressed image has {size} bytes, expected {expected}")
        return _threads.decompressor.decompress(data, allow_extra_data=False)
    except zstandard.ZstdError as error:
        raise ProtocolError(f"a Zstandard image cannot be decoded: {error}") from error


def _jpeg(data: bytes, shape: tuple[int, int, int]) -> npt.NDArray[np.uint8]:
    try:
        height, width, *_ = simplejpeg.decode_jpeg_header(data)
        if (height, width) != shape[:2]:  # Checked before decoding, which allocates that much memory.
            raise ProtocolError(f"a JPEG image is {height} x {width}, expected {shape[0]} x {shape[1]}")
        pixels: npt.NDArray[np.uint8] = simplejpeg.decode_jpeg(data, colorspace="RGB")
        pixels.flags.writeable = False
    except ValueError as error:
        raise ProtocolError(f"a JPEG image cannot be decoded: {error}") from error
    return pixels


class _Threads(threading.local):
    """One decompressor per thread: threads must not share one, and creating one takes 15 microseconds."""

    def __init__(self) -> None:
        self.decompressor = zstandard.ZstdDecompressor()


_threads = _Threads()
