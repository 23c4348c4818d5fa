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
    """Demonstrations of one phase as padded tensors.

    B demonstrations of at most S steps and T tokens; the loss uses at most L steps of each.

    Attributes:
        phase: phase of all demonstrations.
        tokens: token ids, (B, T), padded with 0.
        previous_actions: action before each step, (B, S).
        loss_steps: indices of the steps in the loss, (B, L), ascending, padded with 0.
        cells: image features at these steps, (B, L, 7, 7, C) in [0, 1].
        actions: target actions at these steps, (B, L), padded with NO_ACTION.
    """

    phase: str
    tokens: Tensor
    previous_actions: Tensor
    loss_steps: Tensor
    cells: Tensor
    actions: Tensor

    def to(self, device: str) -> "ImitationBatch":
        """Copy the batch to a device."""
        tensors = (self.tokens, self.previous_actions, self.loss_steps, self.cells, self.actions)
        return ImitationBatch(self.phase, *(tensor.to(device) for tensor in tensors))


def make_batch(
    demonstrations: Sequence[PhaseDemonstration],
    texts: Sequence[str],
    tokenizer: TextTokenizer,
    share: float = 1.0,
    seed: int | str = 0,
) -> ImitationBatch:
    """Return demonstrations of one phase as a batch.

    Args:
        demonstrations: demonstrations of one phase.
        texts: the instruction of each, in the chosen language.
        tokenizer: tokenizer of the instructions.
        share: share of the steps that repeat the previous action to include in the loss; all other steps are included.
        seed: seed for choosing these steps.
    """
    count, steps = len(demonstrations), max(len(each.actions) for each in demonstrations)
    previous_actions = np.full((count, steps), START_ACTION, np.int64)
    for row, each in enumerate(demonstrations):
        previous_actions[row, 1 : len(each.actions)] = each.actions[:-1]
    chance = random.Random(seed)  # noqa: S311 - not for secrets
    selected = [select_loss_steps(each.actions, share, chance) for each in demonstrations]
    longest = max(map(len, selected))
    loss_steps = np.zeros((count, longest), np.int64)
    cells = np.zeros((count, longest, *demonstrations[0].features.shape[1:]), np.uint8)
    actions = np.full((count, longest), NO_ACTION, np.int64)
    for row, (each, chosen) in enumerate(zip(demonstrations, selected, strict=True)):
        loss_steps[row, : len(chosen)] = chosen
        cells[row, : len(chosen)] = each.features[chosen]
        actions[row, : len(chosen)] = each.actions[chosen]
    return ImitationBatch(
        demonstrations[0].phase,
        tokenize_batch(texts, tokenizer),
        torch.from_numpy(previous_actions),
        torch.from_numpy(loss_steps),
        as_input(cells),
        torch.from_numpy(actions),
    )


def tokenize_batch(texts: Sequence[str], tokenizer: TextTokenizer) -> Tensor:
    """Tokenize texts to ids, (B, T), padded with 0."""
    return padded([tokenizer.encode(text) for text in texts])


def select_loss_steps(actions: Sequence[int] | npt.NDArray[np.uint8], share: float, chance: random.Random) -> list[int]:
    """Return the indices of the steps in the loss: all where the action changes, and a random share of the others."""
    return [
        step
        for step, action in enumerate(actions)
        if step == 0 or action != actions[step - 1] or share >= 1.0 or chance.random() < share
    ]


def action_loss(logits: Tensor, batch: ImitationBatch, pick_up: float = 1.0) -> Tensor:
    """Return the mean cross-entropy of the target actions.

    Args:
        logits: action logits at the steps in the loss, (B, L, 5).
        batch: batch with the target actions.
        pick_up: weight of the pick-up action in navigation; all other actions have weight 1.
    """
    weights = torch.ones(logits.shape[-1], device=logits.device)
    if batch.phase == NAVIGATION:
        weights[Action.INTERACT] = pick_up
    return torch.nn.functional.cross_entropy(
        logits.flatten(0, 1), batch.actions.flatten(), weights, ignore_index=NO_ACTION, reduction="mean"
    )


def draw_text(demonstration: PhaseDemonstration, languages: Sequence[str], chance: random.Random) -> str:
    """Return the instruction in one of the languages, chosen uniformly."""
    return chance.choice(demonstration.texts_in(languages))
