"""Network that classifies things cut out of a frame: kind, colour and look from a crop of 32x32 pixels."""

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor, nn

from arramon_agents.perception.eyes.depth_segmentation import CROP_CHANNELS, MEASURES
from arramon_agents.perception.eyes.vocabulary import COLOURS, KINDS, LOOKS

WIDTHS = (16, 32, 64, 128)
"""Channels of the convolutions, at resolutions 32, 16, 8 and 4."""

HIDDEN = 128
"""Hidden size."""


class NamingNetwork(nn.Module):
    """Predicts kind, colour and look of a thing from its crop and measures. Attribute names are tensor names."""

    def __init__(self) -> None:
        super().__init__()
        layers: list[nn.Module] = []
        for inputs, outputs in zip((CROP_CHANNELS, *WIDTHS[:-1]), WIDTHS, strict=True):
            layers += [nn.Conv2d(inputs, outputs, 3, padding=1, bias=False), nn.BatchNorm2d(outputs)]
            layers += [nn.MaxPool2d(2), nn.ReLU()]  # In the other order the result is the same, and ReLU takes longer.
        self.convolutions = nn.Sequential(*layers)  # (B, 128, 2, 2)
        self.hidden = nn.Sequential(nn.Linear(4 * WIDTHS[-1] + MEASURES, HIDDEN), nn.ReLU(), nn.Dropout(0.1))
        self.head = nn.Linear(HIDDEN, len(KINDS) + len(COLOURS) + len(LOOKS))

    def forward(self, crops: Tensor, measures: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Return logits of kinds, colours and looks, (B, n) each.

        Args:
            crops: (B, 6, 32, 32) from `depth_segmentation.crop`, channels first.
            measures: (B, 5) from `objects.FrameThing.measures`.
        """
        features = self.convolutions(crops).flatten(1)
        logits = self.head(self.hidden(torch.cat([features, measures], 1)))
        kinds, colours, looks = logits.split([len(KINDS), len(COLOURS), len(LOOKS)], dim=1)
        return kinds, colours, looks


def to_network(crops: npt.NDArray[np.float32]) -> Tensor:
    """Convert crops, (B, 32, 32, 6), to the network's input, (B, 6, 32, 32)."""
    return torch.from_numpy(crops).permute(0, 3, 1, 2)  # The channels stay last in memory, which is faster.
