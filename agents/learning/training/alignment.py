"""Alignment of languages: what is read in two texts of one path is pulled together."""

import random
from collections.abc import Sequence

import torch
from torch import Tensor
from torch.nn import functional

from agents.learning.paper import Text
from agents.learning.training.demonstrations import Demonstration

TEMPERATURE = 0.1
"""Of the choice among a batch's texts: the smaller, the more the nearest of the wrong ones count."""


def other_texts(
    demonstrations: Sequence[Demonstration], texts: Sequence[str], languages: Sequence[str], chance: random.Random
) -> tuple[list[int], list[str]]:
    """Return a second text for each demonstration that has one.

    Args:
        demonstrations: of a batch.
        texts: those that are read already.
        languages: of second texts.
        chance: draws among several.

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
    """Return how badly each text finds its second among those of the batch, and the other way round; 0 for no texts.

    Texts are compared by the mean of their words. A plain distance would be least if all texts were read alike.
    """
    if not len(one.words):
        return one.words.new_zeros(())
    alike = _pooled(one) @ _pooled(other).T / TEMPERATURE  # (B, B)
    right = torch.arange(len(alike), device=alike.device)
    return (functional.cross_entropy(alike, right) + functional.cross_entropy(alike.T, right)) / 2.0


def _pooled(text: Text) -> Tensor:
    """Return the direction of the mean word of each text, (B, H)."""
    there = (~text.padding).float()[..., None]
    return functional.normalize((text.words.float() * there).sum(1) / there.sum(1).clamp(min=1.0), dim=-1)
