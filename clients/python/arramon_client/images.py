"""Decodes the images of the protocol into arrays."""

import io

import numpy as np
import numpy.typing as npt
from PIL import Image as PillowImage
from PIL import UnidentifiedImageError

from arramon.v1 import types_pb2
from arramon_client.errors import ProtocolError

THOUSANDTHS = np.float32(0.001)
"""Depth travels as whole thousandths of a unit."""


def decode_rgb(image: types_pb2.Image) -> npt.NDArray[np.uint8]:
    """The picture as an array.

    Args:
        image: in any encoding of the protocol.

    Returns:
        (height, width, 3) uint8. Of a raw image it is a read-only view of the message's own bytes.

    Raises:
        ProtocolError: if the data is not what the message says it is.
    """
    shape = (image.height, image.width, 3)
    if image.encoding == types_pb2.ENCODING_RAW:
        _check_length(image, 3)
        return np.frombuffer(image.data, np.uint8).reshape(shape)
    pixels = np.asarray(_opened(image, ("PNG", "JPEG")).convert("RGB"), np.uint8)
    _check_shape(pixels.shape, shape)
    return pixels


def decode_depth(image: types_pb2.Image) -> npt.NDArray[np.float32]:
    """The depth map as an array.

    Args:
        image: raw or PNG.

    Returns:
        (height, width) float32, units ("metres") along the viewing direction; 0 where nothing was hit.

    Raises:
        ProtocolError: if the data is not what the message says it is.
    """
    shape = (image.height, image.width)
    thousandths: npt.NDArray[np.uint16]
    if image.encoding == types_pb2.ENCODING_RAW:
        _check_length(image, 2)
        thousandths = np.frombuffer(image.data, "<u2").reshape(shape)
    else:
        # Pillow opens 16-bit greyscale as "I;16" or, in some releases, as 32-bit "I": both hold the same numbers.
        thousandths = np.asarray(_opened(image, ("PNG",))).astype(np.uint16)
        _check_shape(thousandths.shape, shape)
    return np.multiply(thousandths, THOUSANDTHS, dtype=np.float32)


def _opened(image: types_pb2.Image, formats: tuple[str, ...]) -> PillowImage.Image:
    try:
        opened = PillowImage.open(io.BytesIO(image.data), formats=formats)
        opened.load()
    except (UnidentifiedImageError, OSError, SyntaxError) as error:
        raise ProtocolError(f"an image that should be {' or '.join(formats)} cannot be decoded: {error}") from error
    return opened


def _check_length(image: types_pb2.Image, bytes_a_pixel: int) -> None:
    expected = image.height * image.width * bytes_a_pixel
    if len(image.data) != expected:
        raise ProtocolError(
            f"a raw image of {image.height} x {image.width} has {len(image.data)} bytes, {expected} expected"
        )


def _check_shape(shape: tuple[int, ...], expected: tuple[int, ...]) -> None:
    if shape != expected:
        raise ProtocolError(f"an image has the shape {shape}, {expected} was announced")
