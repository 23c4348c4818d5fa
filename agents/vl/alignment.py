"""Contrastive loss (InfoNCE) that aligns the encodings of two instructions for the same path in different languages."""

import random
from collections.abc import Sequence

import torch
from torch import Tensor
from torch.nn import functional

from arramon_agents.training.demonstrations import PhaseDemonstration
from arramon_agents.vl.model import EncodedText

TEMPERATURE = 0.1
"""Softmax temperature; the lower, the more the hardest negatives count."""


def other_texts(
    demonstrations: Sequence[PhaseDemonstration], texts: Sequence[str], languages: Sequence[str], chance: random.Random
) -> tuple[list[int], list[str]]:
    """Draw a second text for each demonstration that has one.

    Args:
        demonstrations: the demonstrations of a batch.
        texts: the text of each that the batch already uses.
        languages: languages to choose second texts from.
        chance: random generator.

    Returns:
        Indices of the demonstrations with a second text, and these texts.
    """
    rows, others = [], []
    for row, (each, text) in enumerate(zip(demonstrations, texts, strict=True)):
        there = [other for other in each.texts_in(languages) if other != text]
        if there:
            rows.append(row)
            others.append(chance.choice(there))
    return rows, others


def alignment_loss(one: EncodedText, other: EncodedText) -> Tensor:
    """Return the symmetric InfoNCE loss between first and second texts of a batch; 0 for an empty batch.

    Texts are compared by mean pooling. Minimising a plain distance would collapse all texts into one encoding.
    """
    if not len(one.words):
        return one.words.new_zeros(())
    logits = _mean_pool(one) @ _mean_pool(other).T / TEMPERATURE  # (B, B)
    targets = torch.arange(len(logits), device=logits.device)
    return (functional.cross_entropy(logits, targets) + functional.cross_entropy(logits.T, targets)) / 2.0


def _mean_pool(text: EncodedText) -> Tensor:
    """Return the normalised mean of each text's words, (B, H)."""
    mask = (~text.padding).float()[..., None]
    return functional.normalize((text.words.float() * mask).sum(1) / mask.sum(1).clamp(min=1.0), dim=-1)
