"""Image encodings: the client decodes what the server encodes."""

import numpy as np
import numpy.typing as npt
import pytest

from arramon.v1.types_pb2 import (
    ENCODING_JPEG,
    ENCODING_RAW,
    ENCODING_UNSPECIFIED,
    ENCODING_ZSTD,
    Encoding,
    Image,
)
from arramon_client.transport.images import ImageDecoder
from arramon_server.api.encoding import STANDARD_ENCODINGS, ImageEncoder, MessageEncoder
from arramon_server.api.encoding_choice import choose_encoder
from arramon_server.errors import BadInput
from arramon_server.sim.cameras import Actor, Frame, Viewpoint
from arramon_server.sim.catalogue import ALL_TYPES
from arramon_server.sim.raster.camera import RasterCamera
from arramon_server.sim.room_scene import room_scene

RANDOM = np.random.default_rng(3)
SIZES = (224, 128)
LUMINANCE = np.array([0.299, 0.587, 0.114])


@pytest.fixture(scope="module")
def frames() -> dict[int, list[Frame]]:
    """Rendered frames of each size: three views of the room, with objects."""
    actors = [Actor(type_, (1.5 * i, 4.5, 0.0), scale=2.0) for i, type_ in enumerate(ALL_TYPES[:4])]
    camera = RasterCamera(room_scene())
    return {size: [camera.render(Viewpoint(3.0, 0.0, h), actors, size) for h in (0.0, 30.0, 180.0)] for size in SIZES}


def rgb(
    encoding: Encoding.ValueType, pixels: npt.NDArray[np.uint8], quality: int = 0
) -> tuple[Image, npt.NDArray[np.uint8]]:
    image = Image()
    (data,) = MessageEncoder(encoding, quality).encode("", [(pixels, image)], latest=True)
    image.data = bytes(data)
    return image, ImageDecoder().rgb(image)


def chosen(encoding: Encoding.ValueType, quality: int) -> ImageEncoder:
    return choose_encoder(encoding, quality, STANDARD_ENCODINGS, episodes=1, sensors=["rgb"], size=8)


def depth(encoding: Encoding.ValueType, pixels: npt.NDArray[np.uint16]) -> tuple[Image, npt.NDArray[np.uint16]]:
    image = Image()
    (data,) = MessageEncoder(encoding).encode("", [(pixels, image)], latest=True)
    image.data = bytes(data)
    return image, np.rint(ImageDecoder().depth(image).astype(np.float64) * 1000).astype(np.uint16)


@pytest.mark.parametrize("encoding", [ENCODING_RAW, ENCODING_ZSTD])
@pytest.mark.parametrize("size", SIZES)
def test_lossless_encodings_preserve_every_pixel(
    encoding: Encoding.ValueType, size: int, frames: dict[int, list[Frame]]
) -> None:
    for frame in frames[size]:
        image, back = rgb(encoding, frame.rgb)
        assert (image.height, image.width, image.encoding) == (size, size, encoding)
        assert np.array_equal(back, frame.rgb)
        image, metres = depth(encoding, frame.depth)
        assert (image.height, image.width, image.encoding) == (size, size, encoding)
        assert np.array_equal(metres, frame.depth)


@pytest.mark.parametrize("encoding", [ENCODING_RAW, ENCODING_ZSTD])
@pytest.mark.parametrize("shape", [(224, 224), (128, 128), (1, 1), (3, 5)])
def test_lossless_encodings_preserve_random_noise(encoding: Encoding.ValueType, shape: tuple[int, int]) -> None:
    pixels = RANDOM.integers(0, 256, (*shape, 3), np.uint8)
    assert np.array_equal(rgb(encoding, pixels)[1], pixels)
    distances = RANDOM.integers(0, 65536, shape, np.uint16)
    assert np.array_equal(depth(encoding, distances)[1], distances)


@pytest.mark.parametrize("encoding", STANDARD_ENCODINGS)
@pytest.mark.parametrize("values", [(0, 0), (65535, 65535), (0, 65535), (1, 256)])
def test_standard_encodings_preserve_extreme_depths(encoding: Encoding.ValueType, values: tuple[int, int]) -> None:
    distances = np.resize(np.array(values, np.uint16), (128, 128))
    assert np.array_equal(depth(encoding, distances)[1], distances)


@pytest.mark.parametrize("encoding", STANDARD_ENCODINGS)
def test_noncontiguous_arrays_are_encoded_correctly(encoding: Encoding.ValueType) -> None:
    pixels = np.zeros((16, 8, 4), np.uint8)[..., :3].transpose(1, 0, 2)
    assert np.array_equal(rgb(encoding, pixels)[1], np.zeros((8, 16, 3)))
    distances = RANDOM.integers(0, 65536, (4, 6), np.uint16)
    assert np.array_equal(depth(encoding, distances.T)[1], distances.T)


@pytest.mark.parametrize("size", SIZES)
def test_jpeg_colours_are_close_and_depth_is_exact(size: int, frames: dict[int, list[Frame]]) -> None:
    for frame in frames[size]:
        image, back = rgb(ENCODING_JPEG, frame.rgb)
        assert (image.height, image.width, image.encoding) == (size, size, ENCODING_JPEG)
        error = back.astype(int) - frame.rgb
        assert 0 < np.abs(error).mean() < 8  # stripes of one pixel, and colour at half resolution
        assert np.abs(error @ LUMINANCE).mean() < 3
        assert np.abs(error @ LUMINANCE).max() < 32
        image, metres = depth(ENCODING_JPEG, frame.depth)
        assert image.encoding == ENCODING_ZSTD
        assert np.array_equal(metres, frame.depth)


def test_higher_jpeg_quality_is_larger_and_more_accurate(frames: dict[int, list[Frame]]) -> None:
    pixels = frames[224][1].rgb
    found = [rgb(ENCODING_JPEG, pixels, quality) for quality in (1, 50, 90, 100)]
    lengths = [len(image.data) for image, _ in found]
    errors = [np.abs(back.astype(int) - pixels).mean() for _, back in found]
    assert lengths == sorted(set(lengths))
    assert errors == sorted(set(errors), reverse=True)
    assert rgb(ENCODING_JPEG, pixels)[0] == found[2][0]


def test_zstd_images_are_less_than_a_third_in_size(frames: dict[int, list[Frame]]) -> None:
    for frame in frames[224]:
        assert len(rgb(ENCODING_ZSTD, frame.rgb)[0].data) < frame.rgb.nbytes / 3
        assert len(depth(ENCODING_ZSTD, frame.depth)[0].data) < frame.depth.nbytes / 10


@pytest.mark.parametrize(("requested", "quality", "encoding", "in_force"), [
    (ENCODING_UNSPECIFIED, 0, ENCODING_RAW, 0), (ENCODING_ZSTD, 0, ENCODING_ZSTD, 0),
    (ENCODING_JPEG, 0, ENCODING_JPEG, 90), (ENCODING_JPEG, 1, ENCODING_JPEG, 1),
    (ENCODING_JPEG, 100, ENCODING_JPEG, 100),
])  # fmt: skip
def test_chosen_encoding_and_quality_follow_the_request(
    requested: Encoding.ValueType, quality: int, encoding: Encoding.ValueType, in_force: int
) -> None:
    encoder = chosen(requested, quality)
    assert (encoder.encoding, encoder.jpeg_quality) == (encoding, in_force)


@pytest.mark.parametrize(("requested", "quality", "said"), [
    (9, 0, "encoding 9 is not offered; see ServerInfo.encodings"),
    (ENCODING_JPEG, 101, "jpeg_quality is 101, expected 1 to 100, or 0 for 90"),
    (ENCODING_RAW, 90, "jpeg_quality is 90, expected 0 with ENCODING_RAW: only ENCODING_JPEG has a quality"),
    (ENCODING_ZSTD, 1, "jpeg_quality is 1, expected 0 with ENCODING_ZSTD: only ENCODING_JPEG has a quality"),
    (ENCODING_UNSPECIFIED, 90, "jpeg_quality is 90, expected 0 with ENCODING_RAW: only ENCODING_JPEG has a quality"),
])  # fmt: skip
def test_invalid_encoding_requests_are_refused(requested: int, quality: int, said: str) -> None:
    with pytest.raises(BadInput) as caught:
        chosen(Encoding.ValueType(requested), quality)
    assert str(caught.value) == said
