"""Interface of visual encoders, from RGB and depth to a 7x7 grid of features; quantisation, resizing, feature cache."""

from typing import Protocol

import numpy as np
import numpy.typing as npt

from arramon_agents.perception.frame_cache import FrameCache

GRID = 7
"""Number of rows, and of columns, of cells into which an image is divided."""

DEFAULT = "eyes"
"""Name of the default encoder."""

FOLDER = "folder="
"""Prefix of names of encoders that use a transformers vision model; the folder of the model follows."""


class VisualEncoder(Protocol):
    """Interface of frozen visual encoders. The features of an image do not depend on its batch.

    Attributes:
        name: name for `registry.open_encoder`.
        channels: number of features of a cell, C.
        image_size: side length of the input images, in pixels.
        channel_names: name of each feature, such as "kind:mug"; empty if the features have no names.
        fingerprint: short hash of code version and weights, used as the key of cached features.
    """

    name: str
    channels: int
    image_size: int
    channel_names: tuple[str, ...]
    fingerprint: str

    def encode(self, rgb: npt.NDArray[np.uint8], depth: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
        """Return the features of a batch of images.

        Args:
            rgb: (B, size, size, 3) uint8.
            depth: (B, size, size) float32, in metres; 0 where there is nothing.

        Returns:
            (B, 7, 7, C) float32 in [0, 1]; the first row is the top of the image, the first column its left.
        """


def quantise(features: npt.NDArray[np.float32]) -> npt.NDArray[np.uint8]:
    """Quantise features in [0, 1] to 0..255; this is done in training and at play."""
    whole: npt.NDArray[np.uint8] = np.rint(np.clip(features, 0.0, 1.0) * 255.0).astype(np.uint8)
    return whole


def resize(
    rgb: npt.NDArray[np.uint8], depth: npt.NDArray[np.float32], size: int
) -> tuple[npt.NDArray[np.uint8], npt.NDArray[np.float32]]:
    """Return images resized by nearest neighbour; the same arrays if they have this size already.

    Args:
        rgb: (B, H, H, 3) uint8.
        depth: (B, H, H) float32.
        size: the new side length.
    """
    given = rgb.shape[1]
    if given == size:
        return rgb, depth
    nearest = (np.arange(size) * 2 + 1) * given // (2 * size)
    return rgb[:, nearest][:, :, nearest], depth[:, nearest][:, :, nearest]


class FeatureCache:
    """Cache of visual features: an agent that is stuck sees the same image again.

    Args:
        encoder: the visual encoder.
        frames: number of recent images whose features are cached, 4 kB each with the encoder "eyes".
    """

    def __init__(self, encoder: VisualEncoder, frames: int = 1024) -> None:
        self._image_size = encoder.image_size
        self._seen: FrameCache[npt.NDArray[np.uint8]] = FrameCache(
            lambda rgb, depth: quantise(encoder.encode(rgb, depth)), frames
        )

    def features(self, rgb: npt.NDArray[np.uint8], depth: npt.NDArray[np.float32]) -> npt.NDArray[np.uint8]:
        """Return the quantised features of a batch of images, (B, 7, 7, C).

        Args:
            rgb: (B, H, H, 3) uint8, of any side length.
            depth: (B, H, H) float32, in metres; 0 where there is nothing.
        """
        return np.stack(self._seen.find(*resize(rgb, depth, self._image_size)))
