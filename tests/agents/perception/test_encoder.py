"""Contract of all visual encoders: shape, range and repeatability of features."""

import numpy as np
import numpy.typing as npt
import pytest

from arramon_agents.perception.encoder import GRID, FeatureCache, quantise, resize
from arramon_agents.perception.pooled import COLOURS, PooledEncoder
from arramon_agents.perception.registry import encoder_names, open_encoder


@pytest.mark.parametrize("name", encoder_names())
def test_every_encoder_keeps_to_the_interface(name: str) -> None:
    encoder = open_encoder(name)
    random = np.random.default_rng(1)
    size = encoder.image_size
    rgb = random.integers(0, 256, (3, size, size, 3), np.uint8)
    depth = random.uniform(0, 65.535, (3, size, size)).astype(np.float32)
    features = encoder.encode(rgb, depth)
    assert encoder.name == name
    assert features.shape == (3, GRID, GRID, encoder.channels)
    assert features.dtype == np.float32
    assert features.min() >= 0
    assert features.max() <= 1
    assert len(encoder.channel_names) in (0, encoder.channels)
    np.testing.assert_allclose(encoder.encode(rgb[1:2], depth[1:2]), features[1:2], atol=1e-5)
    assert encoder.fingerprint


def test_pooled_finds_colours_and_nearness_in_their_cell() -> None:
    rgb = np.full((1, 112, 112, 3), COLOURS["grey"], np.uint8)
    depth = np.full((1, 112, 112), 20.0, np.float32)
    rgb[0, 16:32, 96:112] = COLOURS["purple"]  # The second row, the last column.
    depth[0, 16:32, 96:112] = 3.0
    encoder = PooledEncoder()
    features = encoder.encode(rgb, depth)[0]
    purple = features[..., encoder.channel_names.index("near colour:purple")]
    assert purple[1, 6] == 1
    assert purple.sum() == 1
    assert features[1, 6, encoder.channel_names.index("nearest")] == 0.25


def test_resizing_takes_the_nearest_pixel() -> None:
    rgb = np.arange(16, dtype=np.uint8).reshape(1, 4, 4, 1).repeat(3, 3)
    depth = np.arange(16, dtype=np.float32).reshape(1, 4, 4)
    small, far = resize(rgb, depth, 2)
    assert small[0, :, :, 0].tolist() == far[0].tolist() == [[5, 7], [13, 15]]
    assert resize(rgb, depth, 4)[0] is rgb


def test_features_are_rounded_to_bytes() -> None:
    assert quantise(np.array([-0.1, 0.0, 0.5, 1.0, 1.2], np.float32)).tolist() == [0, 0, 128, 255, 255]


def test_an_unknown_encoder_is_named() -> None:
    with pytest.raises(ValueError, match="there is no visual encoder 'resnet'; there are "):
        open_encoder("resnet")


class CountingEncoder(PooledEncoder):
    """Counts the images that it encodes."""

    def __init__(self) -> None:
        super().__init__()
        self.images = 0

    def encode(self, rgb: npt.NDArray[np.uint8], depth: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
        self.images += len(rgb)
        return super().encode(rgb, depth)


def test_equal_images_are_encoded_once_while_they_are_remembered() -> None:
    random = np.random.default_rng(2)
    rgb = random.integers(0, 256, (4, 112, 112, 3), np.uint8)
    depth = random.uniform(0, 20, (4, 112, 112)).astype(np.float32)
    depth[1], rgb[1] = depth[0], rgb[0]
    depth[2] = depth[3]  # Not the image 3: the colours differ.
    encoder = CountingEncoder()
    memory = FeatureCache(encoder, frames=2)
    expected = quantise(PooledEncoder().encode(rgb, depth))
    for images, computed in [([0, 1], 1), ([2, 0, 2], 2), ([0], 2), ([3], 3), ([0, 3], 3), ([2], 4)]:
        np.testing.assert_array_equal(memory.features(rgb[images], depth[images]), expected[images])
        assert encoder.images == computed, images
