"""Batches of demonstrations as padded tensors, and their loss."""

import random
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor

from arramon_agents.reading.tokenizers import TextTokenizer
from arramon_agents.training.batches import NO_ACTION, padded
from arramon_agents.training.demonstrations import PhaseDemonstration
from arramon_agents.vl.model import START_ACTION, as_input
from arramon_client.agent import Action
from arramon_client.world import NAVIGATION


@dataclass(frozen=True)
class ImitationBatch:
    """Demonstrations of one phase as tensors, with the steps that the loss uses.

    B demonstrations, the longest with S steps and T tokens; the loss uses at most L steps of each.

    Attributes:
        phase: of all demonstrations.
        tokens: (B, T), 0 at the end for padding.
        before: action before each step, (B, S).
        at: indices of the steps in the loss, (B, L), ascending; 0 after the last.
        cells: features of the images at these, (B, L, 7, 7, C) in [0, 1].
        actions: right action at these, (B, L); NO_ACTION after the last.
    """

    phase: str
    tokens: Tensor
    before: Tensor
    at: Tensor
    cells: Tensor
    actions: Tensor

    def to(self, device: str) -> "ImitationBatch":
        """Return the batch on a device."""
        tensors = (self.tokens, self.before, self.at, self.cells, self.actions)
        return ImitationBatch(self.phase, *(tensor.to(device) for tensor in tensors))


def make_batch(
    demonstrations: Sequence[PhaseDemonstration],
    texts: Sequence[str],
    tokenizer: TextTokenizer,
    share: float = 1.0,
    seed: int | str = 0,
) -> ImitationBatch:
    """Return demonstrations of one phase as tensors.

    Args:
        demonstrations: of one phase.
        texts: the instruction of each, in the chosen language.
        tokenizer: of the instructions.
        share: of the steps that repeat the previous action, the share in the loss; all others are in it.
        seed: for the choice of these steps.
    """
    count, steps = len(demonstrations), max(len(each.actions) for each in demonstrations)
    before = np.full((count, steps), START_ACTION, np.int64)
    for row, each in enumerate(demonstrations):
        before[row, 1 : len(each.actions)] = each.actions[:-1]
    chance = random.Random(seed)  # noqa: S311 - not for secrets
    learned = [loss_steps(each.actions, share, chance) for each in demonstrations]
    most = max(map(len, learned))
    at = np.zeros((count, most), np.int64)
    cells = np.zeros((count, most, *demonstrations[0].features.shape[1:]), np.uint8)
    actions = np.full((count, most), NO_ACTION, np.int64)
    for row, (each, chosen) in enumerate(zip(demonstrations, learned, strict=True)):
        at[row, : len(chosen)] = chosen
        cells[row, : len(chosen)] = each.features[chosen]
        actions[row, : len(chosen)] = each.actions[chosen]
    return ImitationBatch(
        demonstrations[0].phase,
        as_tokens(texts, tokenizer),
        torch.from_numpy(before),
        torch.from_numpy(at),
        as_input(cells),
        torch.from_numpy(actions),
    )


def as_tokens(texts: Sequence[str], tokenizer: TextTokenizer) -> Tensor:
    """Return texts as token ids, (B, T), 0 after the end of each."""
    return padded([tokenizer.encode(text) for text in texts])


def loss_steps(actions: Sequence[int] | npt.NDArray[np.uint8], share: float, chance: random.Random) -> list[int]:
    """Return the indices of the steps in the loss: those where the action changes, and a share of the others."""
    return [
        step
        for step, action in enumerate(actions)
        if step == 0 or action != actions[step - 1] or share >= 1.0 or chance.random() < share
    ]


def action_loss(values: Tensor, batch: ImitationBatch, pick_up: float = 1.0) -> Tensor:
    """Return the mean cross entropy of the target actions.

    Args:
        values: logits of all actions at the steps in the loss, (B, L, 5).
        batch: with the target actions.
        pick_up: weight of the pick-up in the streets; all others have 1.
    """
    weights = torch.ones(values.shape[-1], device=values.device)
    if batch.phase == NAVIGATION:
        weights[Action.INTERACT] = pick_up
    return torch.nn.functional.cross_entropy(
        values.flatten(0, 1), batch.actions.flatten(), weights, ignore_index=NO_ACTION, reduction="mean"
    )


def draw_text(demonstration: PhaseDemonstration, languages: Sequence[str], chance: random.Random) -> str:
    """Return the instruction in one of its languages, chosen uniformly."""
    return chance.choice(demonstration.read_in(languages))
