"""Batches of demonstrations, in an order determined by seed and epoch; padding of token ids."""

import random
from collections.abc import Sequence

import numpy as np
import torch
from torch import Tensor

from arramon_agents.training.demonstrations import PhaseDemonstration

NO_ACTION = -1
"""Target action after the end of a demonstration, ignored by the loss."""

POOL = 16
"""Number of batches per pool: demonstrations are sorted by length within a pool, to reduce padding."""


def epoch_batches(demonstrations: Sequence[PhaseDemonstration], phase: str, size: int, seed: str) -> list[list[int]]:
    """Return the batches of an epoch of one phase, each as indices of demonstrations, determined by the seed."""
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
    """Batches of the demonstrations of one phase, reshuffled in each epoch.

    Args:
        demonstrations: demonstrations of any phases.
        phase: phase of the demonstrations to use.
        size: number of demonstrations in a batch.
        seed: seed of the order.

    Attributes:
        count: number of batches in an epoch.
    """

    def __init__(self, demonstrations: Sequence[PhaseDemonstration], phase: str, size: int, seed: int) -> None:
        self._demonstrations, self._phase, self._size, self._seed = demonstrations, phase, size, seed
        self._epoch, self._batches = 0, self._draw(0)
        self.count = len(self._batches)

    def batch(self, step: int) -> list[int]:
        """Return the batch of a step, as indices of demonstrations."""
        epoch, place = divmod(step, self.count)
        if epoch != self._epoch:
            self._epoch, self._batches = epoch, self._draw(epoch)
        return self._batches[place]

    def _draw(self, epoch: int) -> list[list[int]]:
        return epoch_batches(self._demonstrations, self._phase, self._size, f"{self._seed}/{epoch}")


def padded(texts: Sequence[Sequence[int]]) -> Tensor:
    """Return the token ids of texts as one tensor, (B, T), padded with 0."""
    tokens = np.zeros((len(texts), max(map(len, texts), default=0)), np.int64)
    for row, ids in enumerate(texts):
        tokens[row, : len(ids)] = ids
    return torch.from_numpy(tokens)
