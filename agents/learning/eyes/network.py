"""The encoder's network: a small U-net from RGB and depth to kinds, colours and looks for each block of pixels."""

import math
from dataclasses import dataclass
from functools import lru_cache

import torch
from torch import Tensor, nn
from torch.nn import functional

from agents.learning.eyes.vocabulary import COLOURS, KINDS, LOOKS

BLOCKS = 28
"""Rows and columns of blocks for which labels are predicted."""

FIELD_OF_VIEW = 60.0
"""Degrees, vertical and horizontal: frames are square."""

EYE_HEIGHT = 0.525
"""Height of the camera above the ground, in units."""

LOW, HIGH = 0.4, 4.0
"""Heights above the ground at which the two scales of height end, in units."""

CHANNELS = 6
"""Input channels: red, green, blue, nearness, height in fine, height in coarse."""


@dataclass(frozen=True, slots=True)
class Sizes:
    """Sizes of the network.

    Attributes:
        image: side length of the images, a multiple of 56.
        fine, middle, coarse: channels at 56, 28 and 14 rows and columns.
    """

    image: int = 224
    fine: int = 32
    middle: int = 64
    coarse: int = 96


class Predictions(tuple[Tensor, Tensor, Tensor]):
    """Logits of kinds, colours and looks: (B, n, 28, 28) each."""

    __slots__ = ()


class EyesNetwork(nn.Module):
    """Predicts what is anywhere in each of 28 x 28 blocks of pixels.

    The image is cut into 56 x 56 patches, whose pixels are channels of the first layer: little is computed at a high
    resolution, where it would take most of the time.

    Args:
        sizes: of the network.
    """

    def __init__(self, sizes: Sizes | None = None) -> None:
        super().__init__()
        self.sizes = sizes or Sizes()
        a, b, c = self.sizes.fine, self.sizes.middle, self.sizes.coarse
        self.patch = self.sizes.image // (2 * BLOCKS)
        self.stem = _convolution(CHANNELS * self.patch**2, a, size=1)
        self.to_middle = nn.Sequential(_convolution(a, b, stride=2), _Bottleneck(b))
        self.to_coarse = nn.Sequential(_convolution(b, c, stride=2), _Bottleneck(c), _Bottleneck(c))
        self.back = nn.Conv2d(c, b, 1)
        self.mix = _Bottleneck(b)
        self.head = nn.Conv2d(b, len(KINDS) + len(COLOURS) + len(LOOKS), 1)

    def forward(self, images: Tensor) -> Predictions:
        """Return logits.

        Args:
            images: (B, 6, image, image) of `prepare`.
        """
        fine = self.stem(functional.pixel_unshuffle(images, self.patch))  # (B, fine, 56, 56)
        middle = self.to_middle(fine)  # (B, middle, 28, 28)
        coarse = self.to_coarse(middle)  # (B, coarse, 14, 14)
        middle = self.mix(middle + functional.interpolate(self.back(coarse), scale_factor=2, mode="nearest"))
        return Predictions(self.head(middle).split([len(KINDS), len(COLOURS), len(LOOKS)], dim=1))


def prepare(rgb: Tensor, depth: Tensor) -> Tensor:
    """Return the network's input, (B, 6, size, size).

    Args:
        rgb: (B, size, size, 3) uint8.
        depth: (B, size, size) float32 in units along the viewing direction; 0 where there is nothing.
    """
    colours = rgb.permute(0, 3, 1, 2).to(torch.float32) / 255.0 - 0.5
    seen = depth > 0.0
    nearness = torch.where(seen, 1.0 / (1.0 + depth), 0.0)
    height = torch.where(seen, EYE_HEIGHT - downward(depth.shape[-1]) * depth, HIGH)
    low, high = height.clamp(0.0, LOW) / LOW, height.clamp(0.0, HIGH) / HIGH
    geometry = torch.stack([2.0 * nearness, low, high], dim=1)
    return torch.cat([colours, geometry], dim=1).contiguous(memory_format=torch.channels_last)


@lru_cache(4)
def downward(size: int) -> Tensor:
    """Return how far the rays of each row go down, (size, 1), in units per unit ahead."""
    focal = size / 2 / math.tan(math.radians(FIELD_OF_VIEW / 2))
    return ((torch.arange(size, dtype=torch.float32) + 0.5 - size / 2) / focal)[:, None]


class _Bottleneck(nn.Module):
    """A 3x3 convolution between two that halve and double the channels, around which the input is added."""

    def __init__(self, channels: int) -> None:
        super().__init__()
        self.first = _convolution(channels, channels // 2, size=1)
        self.second = _convolution(channels // 2, channels // 2)
        self.third = nn.Sequential(nn.Conv2d(channels // 2, channels, 1, bias=False), nn.BatchNorm2d(channels))

    def forward(self, x: Tensor) -> Tensor:
        return functional.relu(x + self.third(self.second(self.first(x))))


def _convolution(inputs: int, outputs: int, *, size: int = 3, stride: int = 1) -> nn.Sequential:
    return nn.Sequential(
        nn.Conv2d(inputs, outputs, size, stride, padding=size // 2, bias=False), nn.BatchNorm2d(outputs), nn.ReLU()
    )
