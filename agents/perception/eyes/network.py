"""Block network of the encoder: a small U-Net from RGB and depth to kind, colour and look of each block of pixels."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor, nn
from torch.nn import functional
from torch.nn.utils.fusion import fuse_conv_bn_eval

from arramon_agents.perception.eyes.kernels import fill_input
from arramon_agents.perception.eyes.pixel_rays import rays
from arramon_agents.perception.eyes.vocabulary import COLOURS, KINDS, LOOKS, look_slices
from arramon_client.world import EYE_HEIGHT

BLOCKS = 28
"""Number of rows, and of columns, of blocks."""

LOW, HIGH = 0.4, 4.0
"""Upper ends of the two height scales, in units above the ground."""

CHANNELS = 6
"""Input channels: red, green, blue, nearness, height on a fine scale, height on a coarse scale."""


@dataclass(frozen=True, slots=True)
class EyesSizes:
    """Sizes of the network. Field names are keys in files of weights.

    Attributes:
        image: side length of the images, a multiple of 56.
        fine, middle, coarse: channels at resolutions 56, 28 and 14.
    """

    image: int = 224
    fine: int = 32
    middle: int = 64
    coarse: int = 96


class Predictions(tuple[Tensor, Tensor, Tensor]):
    """Logits of kinds, colours and looks: (B, n) for things, (B, n, 28, 28) for blocks."""

    __slots__ = ()


class Probabilities(tuple[Tensor, Tensor, Tensor]):
    """Probabilities of kinds, of colours, and of looks within their groups, in the shape of the logits."""

    __slots__ = ()


def probabilities(predictions: Predictions) -> Probabilities:
    """Convert logits to probabilities; those of looks sum to 1 within each group."""
    kinds, colours, looks = predictions
    groups = [looks[:, places].softmax(1) for places in look_slices().values()]
    return Probabilities((kinds.softmax(1), colours.softmax(1), torch.cat(groups, 1)))


class EyesNetwork(nn.Module):
    """Predicts what each of 28 x 28 blocks of pixels shows. Attribute names are tensor names in weights.

    The input is the image as 56 x 56 patches, whose pixels are channels (`prepare`): layers at full resolution would
    take most of the time.

    Args:
        sizes: sizes of the network.
    """

    def __init__(self, sizes: EyesSizes | None = None) -> None:
        super().__init__()
        self.sizes = sizes or EyesSizes()
        a, b, c = self.sizes.fine, self.sizes.middle, self.sizes.coarse
        self.stem = _convolution(CHANNELS * patch_size(self.sizes.image) ** 2, a, size=1)
        self.to_middle = nn.Sequential(_convolution(a, b, stride=2), _Bottleneck(b))
        self.to_coarse = nn.Sequential(_convolution(b, c, stride=2), _Bottleneck(c), _Bottleneck(c))
        self.back = nn.Conv2d(c, b, 1)
        self.mix = _Bottleneck(b)
        self.head = nn.Conv2d(b, len(KINDS) + len(COLOURS) + len(LOOKS), 1)

    def forward(self, images: Tensor) -> Predictions:
        """Return logits.

        Args:
            images: (B, 6 * pixels of a patch, 56, 56) from `prepare`.
        """
        fine = self.stem(images)  # (B, fine, 56, 56)
        middle = self.to_middle(fine)  # (B, middle, 28, 28)
        coarse = self.to_coarse(middle)  # (B, coarse, 14, 14)
        middle = self.mix(middle + functional.interpolate(self.back(coarse), scale_factor=2, mode="nearest"))
        return Predictions(self.head(middle).split([len(KINDS), len(COLOURS), len(LOOKS)], dim=1))


def patch_size(size: int) -> int:
    """Return the side length of patches for an image size, in pixels."""
    return size // (2 * BLOCKS)


def prepare(rgb: npt.NDArray[np.uint8], depth: npt.NDArray[np.float32]) -> Tensor:
    """Return the network's input, (B, 6 * pixels of a patch, 56, 56), with the channels last in memory.

    Args:
        rgb: (B, size, size, 3) uint8.
        depth: (B, size, size) float32 in units along the viewing direction; 0 where there is nothing.
    """
    size = depth.shape[1]
    patch = patch_size(size)
    images = np.empty((len(depth), size // patch, size // patch, CHANNELS * patch**2), np.float32)
    for each, ahead, image in zip(rgb, depth, images, strict=True):
        fill_input(each, ahead, rays(size), EYE_HEIGHT, LOW, HIGH, patch, image)
    return torch.from_numpy(images).permute(0, 3, 1, 2)


class _Bottleneck(nn.Module):
    """Residual bottleneck block: a 3x3 convolution on half of the channels, between two 1x1 convolutions."""

    def __init__(self, channels: int) -> None:
        super().__init__()
        self.first = _convolution(channels, channels // 2, size=1)
        self.second = _convolution(channels // 2, channels // 2)
        self.third = nn.Sequential(nn.Conv2d(channels // 2, channels, 1, bias=False), nn.BatchNorm2d(channels))

    def forward(self, x: Tensor) -> Tensor:
        return functional.relu(x + self.third(self.second(self.first(x))), inplace=True)


def prepare_for_inference(network: nn.Module) -> None:
    """Fold batch normalisation of a trained network into its convolutions, and apply ReLU in place."""
    for child in network.modules():
        if isinstance(child, nn.ReLU):
            child.inplace = True
        if isinstance(child, nn.Sequential):
            for place in range(len(child) - 1):
                convolution, norm = child[place], child[place + 1]
                if isinstance(convolution, nn.Conv2d) and isinstance(norm, nn.BatchNorm2d):
                    child[place], child[place + 1] = fuse_conv_bn_eval(convolution, norm), nn.Identity()


def _convolution(inputs: int, outputs: int, *, size: int = 3, stride: int = 1) -> nn.Sequential:
    return nn.Sequential(
        nn.Conv2d(inputs, outputs, size, stride, padding=size // 2, bias=False), nn.BatchNorm2d(outputs), nn.ReLU()
    )
