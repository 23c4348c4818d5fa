"""Batches of an epoch, in an order that follows from seed and epoch alone, and padded token ids."""

import random
from collections.abc import Sequence

import numpy as np
import torch
from torch import Tensor

from arramon_agents.training.demonstrations import PhaseDemonstration

NO_ACTION = -1
"""Target action after the end of a demonstration, ignored by the loss."""

POOL = 16
"""Number of batches whose demonstrations are sorted by length together, so that little is padding."""


def epoch_batches(demonstrations: Sequence[PhaseDemonstration], phase: str, size: int, seed: str) -> list[list[int]]:
    """Return which demonstrations of a phase make each batch of an epoch, as indices; they follow from the seed."""
    chance = random.Random(f"{seed}/{phase}")  # noqa: S311 - not for secrets
    order = [number for number, each in enumerate(demonstrations) if each.phase == phase]
    chance.shuffle(order)
    batches = []
    for at in range(0, len(order), size * POOL):
        pool = sorted(order[at : at + size * POOL], key=lambda number: len(demonstrations[number].actions))
        batches += [pool[start : start + size] for start in range(0, len(pool), size)]
    chance.shuffle(batches)
    return batches


class EpochBatches:
    """The batches of a phase's demonstrations, epoch after epoch, each epoch in another order.

    Args:
        demonstrations: of any phases.
        phase: of those that are in the batches.
        size: number of demonstrations in a batch.
        seed: of the orders.

    Attributes:
        count: number of batches in an epoch.
    """

    def __init__(self, demonstrations: Sequence[PhaseDemonstration], phase: str, size: int, seed: int) -> None:
        self._demonstrations, self._phase, self._size, self._seed = demonstrations, phase, size, seed
        self._epoch, self._batches = 0, self._draw(0)
        self.count = len(self._batches)

    def batch(self, step: int) -> list[int]:
        """Return which demonstrations make the batch of a step, as indices."""
        epoch, place = divmod(step, self.count)
        if epoch != self._epoch:
            self._epoch, self._batches = epoch, self._draw(epoch)
        return self._batches[place]

    def _draw(self, epoch: int) -> list[list[int]]:
        return epoch_batches(self._demonstrations, self._phase, self._size, f"{self._seed}/{epoch}")


def padded(texts: Sequence[Sequence[int]]) -> Tensor:
    """Return token ids of texts as one tensor, (B, T), with 0 after a text's end."""
    tokens = np.zeros((len(texts), max(map(len, texts), default=0)), np.int64)
    for row, ids in enumerate(texts):
        tokens[row, : len(ids)] = ids
    return torch.from_numpy(tokens)
