"""Training tasks of the encoder's two networks on labelled frames."""

from collections.abc import Callable
from typing import Protocol

import numpy as np
import numpy.typing as npt
import torch
from torch.nn import functional

from arramon_agents.perception.eyes.depth_segmentation import FrameThing, crop, find_things
from arramon_agents.perception.eyes.naming_network import NamingNetwork, to_network
from arramon_agents.perception.eyes.network import EyesNetwork, EyesSizes, prepare
from arramon_agents.perception.eyes.reach import Reach
from arramon_agents.perception.eyes.targets import LabelTable, loss_of, masked_cross_entropy
from arramon_agents.perception.eyes.vocabulary import KINDS, NONE, look_slices
from arramon_agents.training.trainer import Loss
from arramon_client.world import COLLECTIBLES

MIN_PURITY = 0.6
"""Minimum share of a thing's pixels with the same label for it to be a training example."""

NAMED_LOOKS = {"pattern": 0.7, "shape": 0.5, "shop": 0.3}
"""Loss weights of the looks of cut-out things; looks of walls and facades are predicted for blocks."""

_FIRST_COLLECTIBLE = len(KINDS) - len(COLLECTIBLES)
_WEIGHTS = torch.tensor([0.3 if kind in ("building", "wall") else 1.0 for kind in KINDS])


class FrameWithLabels(Protocol):
    """A frame with the label of each pixel: rgb (size, size, 3), depth (size, size) in units, labels (size, size)."""

    @property
    def rgb(self) -> npt.NDArray[np.uint8]:
        """Colours."""
        ...

    @property
    def depth(self) -> npt.NDArray[np.float32]:
        """Units along the viewing direction."""
        ...

    @property
    def labels(self) -> npt.NDArray[np.uint16]:
        """Indices in the table of labels."""
        ...


FrameOf = Callable[[int], FrameWithLabels]
"""Returns the frame with a number, deterministically."""


class BlocksTask:
    """Training task: predict what is in each block of a frame.

    Args:
        sizes: sizes of the network.
        frame_of: returns frames.
        table: table of their labels.
        batch: number of frames in a batch.
    """

    def __init__(self, sizes: EyesSizes, frame_of: FrameOf, table: LabelTable, batch: int) -> None:
        self.network = EyesNetwork(sizes)
        self._frame_of, self._table, self._batch = frame_of, table, batch

    def loss(self, step: int) -> Loss:
        """Return the loss of a batch of frames."""
        frames = [self._frame_of(number) for number in frame_numbers(step, self._batch)]
        images = prepare(np.stack([frame.rgb for frame in frames]), np.stack([frame.depth for frame in frames]))
        targets = torch.from_numpy(np.stack([self._table.blocks(frame.labels) for frame in frames]))
        return Loss(loss_of(self.network(images), targets))


class NamingTask:
    """Training task: classify things cut out of frames.

    Args:
        frame_of: returns frames.
        table: table of their labels.
        batch: number of frames in a batch.
        reach: which things are cut out.
    """

    def __init__(self, frame_of: FrameOf, table: LabelTable, batch: int, reach: Reach) -> None:
        self.network = NamingNetwork()
        self._frame_of, self._table, self._batch, self._reach = frame_of, table, batch, reach

    def loss(self, step: int) -> Loss:
        """Return the loss of the things in a batch of frames."""
        crops, measures, codes = [], [], []
        for number in frame_numbers(step, self._batch):
            frame = self._frame_of(number)
            for thing in find_things(frame.depth, self._reach):
                label, share = label_of(frame, thing)
                if share >= MIN_PURITY:
                    crops.append(crop(frame.rgb, frame.depth, thing))
                    measures.append(thing.measures)
                    codes.append(self._table.codes[label])
        kinds, colours, looks = self.network(to_network(np.stack(crops)), torch.tensor(measures))
        kind, colour, look = torch.from_numpy(np.stack(codes)).unbind(1)
        is_collectible = kind >= _FIRST_COLLECTIBLE
        total = functional.cross_entropy(kinds, kind, _WEIGHTS)
        total = total + masked_cross_entropy(kinds[:, _FIRST_COLLECTIBLE:], kind - _FIRST_COLLECTIBLE, is_collectible)
        total = (
            total
            + 0.7 * masked_cross_entropy(colours, colour, is_collectible)
            + 0.3 * masked_cross_entropy(colours, colour, colour != NONE)
        )
        for name, places in look_slices().items():
            if name in NAMED_LOOKS:
                inside = (look >= places.start) & (look < places.stop)
                total = total + NAMED_LOOKS[name] * masked_cross_entropy(looks[:, places], look - places.start, inside)
        return Loss(total)


def frame_numbers(step: int, batch: int) -> range:
    """Return the numbers of the frames in the batch of a step; every frame is used once."""
    return range(step * batch, (step + 1) * batch)


def label_of(frame: FrameWithLabels, thing: FrameThing) -> tuple[int, float]:
    """Return the most frequent label of a thing's pixels, and its share of them."""
    numbers, counts = np.unique(frame.labels[thing.rows, thing.columns][thing.mask], return_counts=True)
    most = int(counts.argmax())
    return int(numbers[most]), float(counts[most] / counts.sum())
