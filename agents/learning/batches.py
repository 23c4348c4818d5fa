"""Batches of demonstrations: padded tensors, in an order that follows from seed and epoch alone."""

import random
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from agents.learning.checkpoint import as_input
from agents.learning.demonstrations import Demonstration
from agents.learning.paper import START
from agents.learning.tokenizers import Tokenizer

NO_ACTION = -1
"""Stands for the right action where there is none: after the end."""

POOL = 16
"""Batches whose demonstrations are sorted by length together, so that little is padding."""


@dataclass(frozen=True)
class Batch:
    """Demonstrations of one phase. B of them, the longest with S steps and T tokens.

    Attributes:
        phase: of all.
        tokens: (B, T), 0 at the end for padding.
        cells: (B, S, 7, 7, C) in [0, 1].
        before: action before each step, (B, S).
        actions: right action, (B, S); NO_ACTION after the end.
        weights: of each step in the loss, (B, S); 0 after the end.
    """

    phase: str
    tokens: Tensor
    cells: Tensor
    before: Tensor
    actions: Tensor
    weights: Tensor

    def to(self, device: str) -> "Batch":
        """Return the batch on a device."""
        tensors = (self.tokens, self.cells, self.before, self.actions, self.weights)
        return Batch(self.phase, *(tensor.to(device) for tensor in tensors))


def epoch(demonstrations: Sequence[Demonstration], phase: str, size: int, seed: str) -> list[list[int]]:
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


def make_batch(
    demonstrations: Sequence[Demonstration], texts: Sequence[str], tokenizer: Tokenizer, inflection: float = 1.0
) -> Batch:
    """Return demonstrations of one phase as tensors.

    Args:
        demonstrations: of one phase.
        texts: the instruction of each, in the language in which it is read.
        tokenizer: of the instructions.
        inflection: weight of steps at which the expert's action is another than before; 1 for others.
    """
    encoded = [tokenizer.encode(text) for text in texts]
    count, steps = len(demonstrations), max(len(each.actions) for each in demonstrations)
    tokens = np.zeros((count, max(map(len, encoded))), np.int64)
    cells = np.zeros((count, steps, *demonstrations[0].features.shape[1:]), np.uint8)
    before = np.full((count, steps), START, np.int64)
    actions = np.full((count, steps), NO_ACTION, np.int64)
    weights = np.zeros((count, steps), np.float32)
    for row, (each, numbers) in enumerate(zip(demonstrations, encoded, strict=True)):
        length = len(each.actions)
        tokens[row, : len(numbers)] = numbers
        cells[row, :length] = each.features
        actions[row, :length] = each.actions
        before[row, 1:length] = each.actions[:-1]
        weights[row, :length] = np.where(before[row, :length] == each.actions, 1.0, inflection)
    return Batch(
        demonstrations[0].phase,
        torch.from_numpy(tokens),
        as_input(cells),
        torch.from_numpy(before),
        torch.from_numpy(actions),
        torch.from_numpy(weights),
    )


def loss_of(values: Tensor, batch: Batch) -> Tensor:
    """Return the mean cross entropy of the right actions, weighted by step.

    Args:
        values: of all actions, (B, S, 5).
        batch: with the right ones.
    """
    losses = torch.nn.functional.cross_entropy(
        values.flatten(0, 1), batch.actions.flatten().clamp(min=0), reduction="none"
    )
    weights = batch.weights.flatten()
    return (losses * weights).sum() / weights.sum()


def draw_text(demonstration: Demonstration, languages: Sequence[str], chance: random.Random) -> str:
    """Return the instruction in one of the languages that it has, drawn evenly."""
    there = [language for language in languages if language in demonstration.texts]
    return demonstration.texts[chance.choice(there)]
