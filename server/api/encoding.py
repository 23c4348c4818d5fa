"""How images travel: raw, PNG or JPEG, as `types.proto` has it."""

import io

import numpy as np
import numpy.typing as npt
from PIL import Image as Pillow

from arramon.v1.types_pb2 import ENCODING_JPEG, ENCODING_PNG, ENCODING_RAW, Encoding, Image

OFFERED = (ENCODING_RAW, ENCODING_PNG, ENCODING_JPEG)
"""In the server's order of preference."""

JPEG_QUALITY = 90


def encode_rgb(rgb: npt.NDArray[np.uint8], encoding: Encoding.ValueType) -> Image:
    """A (height, width, 3) uint8 image as a message."""
    return _image(rgb, encoding)


def encode_depth(depth: npt.NDArray[np.uint16], encoding: Encoding.ValueType) -> Image:
    """A (height, width) uint16 depth map as a message; never lossy, so PNG stands in for JPEG."""
    return _image(depth, ENCODING_PNG if encoding == ENCODING_JPEG else encoding)


def _image(pixels: npt.NDArray[np.uint8] | npt.NDArray[np.uint16], encoding: Encoding.ValueType) -> Image:
    height, width = pixels.shape[:2]
    if encoding == ENCODING_RAW:
        little = pixels.astype(pixels.dtype.newbyteorder("<"), copy=False)
        return Image(height=height, width=width, encoding=encoding, data=little.tobytes())
    file = io.BytesIO()
    picture = Pillow.fromarray(pixels)
    if encoding == ENCODING_PNG:
        picture.save(file, "PNG", compress_level=1)
    else:
        picture.save(file, "JPEG", quality=JPEG_QUALITY)
    return Image(height=height, width=width, encoding=encoding, data=file.getvalue())
