"""Alignment of languages: a contrastive loss that pulls together the encodings of two texts for the same path."""

import random
from collections.abc import Sequence

import torch
from torch import Tensor
from torch.nn import functional

from arramon_agents.training.demonstrations import PhaseDemonstration
from arramon_agents.vl.model import Text

TEMPERATURE = 0.1
"""Temperature of the contrastive softmax: the smaller, the more the nearest wrong texts count."""


def other_texts(
    demonstrations: Sequence[PhaseDemonstration], texts: Sequence[str], languages: Sequence[str], chance: random.Random
) -> tuple[list[int], list[str]]:
    """Return a second text for each demonstration that has one.

    Args:
        demonstrations: of a batch.
        texts: their first texts.
        languages: to choose second texts from.
        chance: source of random choices.

    Returns:
        Which demonstrations have a second text, and these texts.
    """
    rows, others = [], []
    for row, (each, text) in enumerate(zip(demonstrations, texts, strict=True)):
        there = [other for other in each.read_in(languages) if other != text]
        if there:
            rows.append(row)
            others.append(chance.choice(there))
    return rows, others


def alignment_loss(one: Text, other: Text) -> Tensor:
    """Return the symmetric InfoNCE loss between first and second texts of a batch; 0 for no texts.

    Texts are compared by the mean of their words. A plain distance would collapse all texts into one encoding.
    """
    if not len(one.words):
        return one.words.new_zeros(())
    alike = _pooled(one) @ _pooled(other).T / TEMPERATURE  # (B, B)
    right = torch.arange(len(alike), device=alike.device)
    return (functional.cross_entropy(alike, right) + functional.cross_entropy(alike.T, right)) / 2.0


def _pooled(text: Text) -> Tensor:
    """Return the normalised mean of each text's words, (B, H)."""
    there = (~text.padding).float()[..., None]
    return functional.normalize((text.words.float() * there).sum(1) / there.sum(1).clamp(min=1.0), dim=-1)
