"""Decoding of images in every encoding."""

import numpy as np
import numpy.typing as npt
import pytest
import simplejpeg
import zstandard

from arramon.v1 import types_pb2
from arramon.v1.types_pb2 import ENCODING_JPEG, ENCODING_RAW, ENCODING_UNSPECIFIED, ENCODING_ZSTD
from arramon_client import ProtocolError
from arramon_client.transport.images import ImageDecoder

RGB = np.random.default_rng(0).integers(0, 256, (5, 7, 3), np.uint8)
DEPTH = np.array([[0, 1, 999], [1000, 65534, 65535]], np.uint16)
METRES = np.array([[0.0, 0.001, 0.999], [1.0, 65.534, 65.535]])
SMOOTH = np.full((16, 24, 3), (200, 100, 50), np.uint8)


def message(pixels: npt.NDArray[np.generic], encoding: int, data: bytes) -> types_pb2.Image:
    number = types_pb2.Encoding.ValueType(encoding)
    return types_pb2.Image(height=pixels.shape[0], width=pixels.shape[1], encoding=number, data=data)


GIBIBYTE = b"\x28\xb5\x2f\xfd\xe0" + (1 << 30).to_bytes(8, "little")
"""The head of a Zstandard frame that states so much content."""


def zstd(data: bytes, *, sized: bool = True) -> bytes:
    return zstandard.ZstdCompressor(write_content_size=sized).compress(data)


def jpeg(pixels: npt.NDArray[np.uint8]) -> bytes:
    return bytes(simplejpeg.encode_jpeg(pixels, quality=90))


def test_raw_rgb_is_a_view_of_the_data() -> None:
    decoded = ImageDecoder().rgb(message(RGB, ENCODING_RAW, RGB.tobytes()))
    assert np.array_equal(decoded, RGB)
    assert not decoded.flags.owndata
    assert not decoded.flags.writeable


def test_compressed_rgb_is_exact() -> None:
    decoded = ImageDecoder().rgb(message(RGB, ENCODING_ZSTD, zstd(RGB.tobytes())))
    assert decoded.dtype == np.uint8
    assert np.array_equal(decoded, RGB)


def test_zstd_frames_of_another_encoder_are_decoded() -> None:
    """Six zeros and the frame's own words: magic, single segment, content size 6, one last RLE block."""
    data = bytes.fromhex("28b52ffd200633000000")
    assert ImageDecoder().rgb(message(RGB[:1, :2], ENCODING_ZSTD, data)).tolist() == [[[0, 0, 0], [0, 0, 0]]]


def test_jpeg_rgb_is_similar() -> None:
    decoded = ImageDecoder().rgb(message(SMOOTH, ENCODING_JPEG, jpeg(SMOOTH)))
    assert decoded.shape == SMOOTH.shape
    assert decoded.dtype == np.uint8
    assert np.abs(decoded.astype(int) - SMOOTH).max() <= 3


@pytest.mark.parametrize(("encoding", "data"), [
    (ENCODING_RAW, DEPTH.astype("<u2").tobytes()), (ENCODING_ZSTD, zstd(DEPTH.astype("<u2").tobytes())),
])  # fmt: skip
def test_depth_is_in_metres(encoding: int, data: bytes) -> None:
    decoded = ImageDecoder().depth(message(DEPTH, encoding, data))
    assert decoded.dtype == np.float32
    assert np.allclose(decoded, METRES, rtol=1e-6, atol=0)
    assert np.array_equal(np.rint(decoded.astype(np.float64) * 1000), DEPTH)


@pytest.mark.parametrize(("encoding", "data"), [
    (ENCODING_RAW, DEPTH.astype("<u2").tobytes()), (ENCODING_ZSTD, zstd(DEPTH.astype("<u2").tobytes())),
])  # fmt: skip
def test_a_segmentation_is_unchanged(encoding: int, data: bytes) -> None:
    decoded = ImageDecoder().segmentation(message(DEPTH, encoding, data))
    assert decoded.dtype == np.uint16
    assert np.array_equal(decoded, DEPTH)


@pytest.mark.parametrize(("encoding", "data", "said"), [
    (ENCODING_RAW, b"12", "a raw image of 5 x 7 has 2 bytes, expected 105"),
    (ENCODING_RAW, RGB.tobytes() + b"1", "has 106 bytes, expected 105"),
    (ENCODING_ZSTD, b"", "a Zstandard image cannot be decoded"),
    (ENCODING_ZSTD, b"no frame", "a Zstandard image cannot be decoded"),
    (ENCODING_ZSTD, zstd(RGB.tobytes())[:-9], "a Zstandard image cannot be decoded"),
    (ENCODING_ZSTD, zstd(RGB.tobytes()) + b"1", "a Zstandard image cannot be decoded"),
    (ENCODING_ZSTD, zstd(RGB.tobytes(), sized=False), "has an unstated number of bytes, expected 105"),
    (ENCODING_ZSTD, zstd(RGB[:4].tobytes()), "a compressed image has 84 bytes, expected 105"),
    (ENCODING_ZSTD, GIBIBYTE, "a compressed image has 1073741824 bytes, expected 105"),
    (ENCODING_JPEG, b"", "a JPEG image cannot be decoded"),
    (ENCODING_JPEG, b"12", "a JPEG image cannot be decoded"),
    (ENCODING_JPEG, jpeg(RGB)[:-20], "a JPEG image cannot be decoded"),
    (ENCODING_JPEG, jpeg(SMOOTH), "a JPEG image is 16 x 24, expected 5 x 7"),
    (ENCODING_UNSPECIFIED, RGB.tobytes(), "an image with 3 bytes per pixel has the encoding 0"),
    (9, RGB.tobytes(), "an image with 3 bytes per pixel has the encoding 9"),
])  # fmt: skip
def test_invalid_images_are_refused(encoding: int, data: bytes, said: str) -> None:
    with pytest.raises(ProtocolError, match=said):
        ImageDecoder().rgb(message(RGB, encoding, data))


PROGRESSIVE = jpeg(SMOOTH).replace(b"\xff\xc0", b"\xff\xc2")
BARE = [bytes((0xFF, marker)) for marker in (0x01, *range(0xD0, 0xD8))]
"""Markers of a JPEG without a length."""


@pytest.mark.parametrize("before", [b"", b"\xff", *BARE, b"\xff\xfe\x00\x02", BARE[0] + b"\xff" + BARE[3]])
def test_progressive_jpegs_are_refused_whatever_comes_before_the_frame(before: bytes) -> None:
    """Their many passes over the image can take minutes."""
    with pytest.raises(ProtocolError, match="a JPEG image is progressive, expected a sequential one"):
        ImageDecoder().rgb(message(SMOOTH, ENCODING_JPEG, PROGRESSIVE[:2] + before + PROGRESSIVE[2:]))


@pytest.mark.parametrize("before", [b"", *BARE])
def test_sequential_jpegs_are_decoded_whatever_comes_before_the_frame(before: bytes) -> None:
    data = jpeg(SMOOTH)
    decoded = ImageDecoder().rgb(message(SMOOTH, ENCODING_JPEG, data[:2] + before + data[2:]))
    assert np.abs(decoded.astype(int) - SMOOTH).max() <= 3


@pytest.mark.parametrize("before", [b"\xff\x00\x00\x40", b"\xff\xfe\x00\x00", b"\xff\xd8", b"\xff\x4f\x00\x02", b"\0"])
def test_jpegs_whose_frame_two_decoders_would_find_in_two_places_are_refused(before: bytes) -> None:
    with pytest.raises(ProtocolError, match="it has no header of a sequential frame"):
        ImageDecoder().rgb(message(SMOOTH, ENCODING_JPEG, PROGRESSIVE[:2] + before + PROGRESSIVE[2:]))


def test_sequential_jpegs_of_many_passes_are_refused() -> None:
    head, scan, rest = jpeg(SMOOTH).partition(b"\xff\xda")
    with pytest.raises(ProtocolError, match="a JPEG image has 9 passes, expected at most 4"):
        ImageDecoder().rgb(message(SMOOTH, ENCODING_JPEG, head + 9 * (scan + rest)))


def test_shared_images_without_shared_memory_are_refused() -> None:
    image = types_pb2.Image(height=5, width=7, encoding=types_pb2.ENCODING_SHARED)
    with pytest.raises(ProtocolError, match="an image with 3 bytes per pixel has the encoding 4"):
        ImageDecoder().rgb(image)


@pytest.mark.parametrize(("encoding", "data", "said"), [
    (ENCODING_RAW, bytes(11), "a raw image of 2 x 3 has 11 bytes, expected 12"),
    (ENCODING_ZSTD, zstd(bytes(18)), "a compressed image has 18 bytes, expected 12"),
    (ENCODING_ZSTD, zstd(bytes(12))[:-1], "a Zstandard image cannot be decoded"),
    (ENCODING_JPEG, jpeg(SMOOTH), "an image with 2 bytes per pixel has the encoding 3"),
])  # fmt: skip
def test_invalid_depth_maps_are_refused(encoding: int, data: bytes, said: str) -> None:
    with pytest.raises(ProtocolError, match=said):
        ImageDecoder().depth(message(DEPTH, encoding, data))
    with pytest.raises(ProtocolError, match=said):
        ImageDecoder().segmentation(message(DEPTH, encoding, data))
