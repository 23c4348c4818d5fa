"""Decoding images in every encoding."""

import io

import numpy as np
import numpy.typing as npt
import pytest
from PIL import Image

from arramon.v1 import types_pb2
from arramon_client import ProtocolError
from arramon_client.images import decode_depth, decode_rgb

RGB = np.random.default_rng(0).integers(0, 256, (5, 7, 3), np.uint8)
DEPTH = np.array([[0, 1, 999], [1000, 65534, 65535]], np.uint16)
METRES = [[0.0, 0.001, 0.999], [1.0, 65.534, 65.535]]


def message(pixels: npt.NDArray[np.generic], encoding: types_pb2.Encoding.ValueType, data: bytes) -> types_pb2.Image:
    return types_pb2.Image(height=pixels.shape[0], width=pixels.shape[1], encoding=encoding, data=data)


def compressed(pixels: npt.NDArray[np.uint8 | np.uint16], format_: str) -> bytes:
    buffer = io.BytesIO()
    Image.fromarray(pixels).save(buffer, format_)
    return buffer.getvalue()


def test_raw_rgb_is_a_view_of_the_message() -> None:
    decoded = decode_rgb(message(RGB, types_pb2.ENCODING_RAW, RGB.tobytes()))
    assert np.array_equal(decoded, RGB)
    assert not decoded.flags.owndata
    assert not decoded.flags.writeable


def test_png_rgb_is_exact() -> None:
    decoded = decode_rgb(message(RGB, types_pb2.ENCODING_PNG, compressed(RGB, "PNG")))
    assert np.array_equal(decoded, RGB)


def test_jpeg_rgb_is_near() -> None:
    smooth = np.full((16, 16, 3), (200, 100, 50), np.uint8)
    decoded = decode_rgb(message(smooth, types_pb2.ENCODING_JPEG, compressed(smooth, "JPEG")))
    assert np.abs(decoded.astype(int) - smooth).max() <= 3


@pytest.mark.parametrize(("encoding", "data"), [
    (types_pb2.ENCODING_RAW, DEPTH.astype("<u2").tobytes()), (types_pb2.ENCODING_PNG, compressed(DEPTH, "PNG")),
])  # fmt: skip
def test_depth_is_in_metres(encoding: types_pb2.Encoding.ValueType, data: bytes) -> None:
    decoded = decode_depth(message(DEPTH, encoding, data))
    assert decoded.dtype == np.float32
    assert np.allclose(decoded, METRES, rtol=1e-6)


@pytest.mark.parametrize(("encoding", "data", "said"), [
    (types_pb2.ENCODING_RAW, b"12", "has 2 bytes, 105 expected"),
    (types_pb2.ENCODING_PNG, b"12", "cannot be decoded"),
    (types_pb2.ENCODING_PNG, compressed(RGB, "PNG")[:60], "cannot be decoded"),
    (types_pb2.ENCODING_PNG, compressed(RGB[:4], "PNG"), r"shape \(4, 7, 3\), \(5, 7, 3\) was announced"),
    (types_pb2.ENCODING_PNG, compressed(RGB, "BMP"), "cannot be decoded"),
])  # fmt: skip
def test_what_is_no_image(encoding: types_pb2.Encoding.ValueType, data: bytes, said: str) -> None:
    with pytest.raises(ProtocolError, match=said):
        decode_rgb(message(RGB, encoding, data))
