"""The paper's models (section 5): vision and language, vision only, language only. Read it from top to bottom.

Two modules of one shape, one for navigation, one for assembly, without shared weights. Each reads the instruction with
an LSTM, keeps its own past actions in another, and looks at the present image alone; attention between words and cells
of the image goes both ways. With the original's sizes (774 words, 2,048 features of a ResNet) they have 1.83, 0.73 and
1.11 million parameters.

In the comments B is the batch, S steps, T words, K = 49 cells, C features of a cell, H = 128.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor, nn
from torch.nn import functional

from arramon_agents.perception.encoder import GRID
from arramon_agents.reading.text_encoders import make_text_encoder
from arramon_agents.vl.config import ModelConfig
from arramon_client.world import PHASES

ACTIONS = 4
START_ACTION = 4
"""Stands for the action before the first; a fifth output that is never right belongs to it in the original."""


class Text(NamedTuple):
    """A batch of instructions as read: words (B, T, H), and which of them are none but padding (B, T)."""

    words: Tensor
    padding: Tensor

    def of(self, rows: Sequence[int]) -> "Text":
        """Return some of the instructions."""
        return Text(self.words[list(rows)], self.padding[list(rows)])


State = tuple[Tensor, Tensor]
"""Of the LSTM over past actions: twice (1, B, H)."""


class PhaseModel(nn.Module):
    """Model of one phase."""

    def __init__(self, config: ModelConfig) -> None:
        super().__init__()
        self.config = c = config
        self.act_embedding = nn.Embedding(ACTIONS + 1, c.action_size)
        self.history = nn.LSTM(c.action_size, c.hidden, batch_first=True, bias=True)
        self.dropout = nn.Dropout(c.dropout)
        if c.reads:
            self.reader = make_text_encoder(c.reader, c.vocabulary, c.word_size, c.hidden)
        if c.sees:
            self.look = nn.Linear(c.channels + (2 * GRID if c.positions else 0), c.hidden)
        if c.sees and c.reads:
            self.similarity = nn.Linear(c.hidden, 1)
            self.fuse_cells = nn.Linear(3 * c.hidden, c.hidden)
            self.fuse_words = nn.Linear(3 * c.hidden, c.hidden)
        self.output = nn.Linear((1 + c.sees + c.reads) * c.hidden, ACTIONS + 1)

    def read(self, tokens: Tensor) -> Text:
        """Read instructions, (B, T) numbers, 0 for padding at the end. A model that reads nothing keeps the padding."""
        padding = tokens == 0  # (B, T)
        words = self.reader(tokens) if self.config.reads else tokens.new_zeros(*tokens.shape, 0).float()
        return Text(words, padding)

    def act(
        self, text: Text, cells: Tensor, before: Tensor, state: State | None = None, at: Tensor | None = None
    ) -> tuple[Tensor, State]:
        """Return the values of all actions at each of S steps in a row, (B, S, 5), and the state after them.

        Args:
            text: the instructions.
            cells: features of the images, (B, S, 7, 7, C), in [0, 1].
            before: the action before each step, (B, S); START_ACTION at the first.
            state: after the step before these; None at the beginning.
            at: numbers of the steps at which alone values are returned and images given, so that these have fewer
                steps than `before`, (B, fewer).
        """
        past, state = self.history(self.dropout(self.act_embedding(before)), state)  # (B, S, H)
        if at is not None:
            past = past.gather(1, at[:, :, None].expand(-1, -1, past.shape[2]))  # (B, fewer, H)
        parts = [past]
        if self.config.sees:
            seen = self.look(self._placed(cells))  # (B, S, K, H)
            if self.config.reads:
                parts += self._seen_and_read(past, seen, text)  # twice (B, S, H)
            else:
                parts.append(_attend(past, (seen,)))  # (B, S, H)
        elif self.config.reads:
            parts.append(self._read(past, text))  # (B, S, H)
        return self.output(self.dropout(torch.cat(parts, -1))), state

    def _placed(self, cells: Tensor) -> Tensor:
        """Return (B, S, K, C), with each cell's row and column as 14 more features if the configuration says so."""
        if self.config.positions:
            one_hot = torch.eye(GRID, device=cells.device)
            row = one_hot[:, None].expand(GRID, GRID, GRID)  # (7, 7, 7)
            column = one_hot[None].expand(GRID, GRID, GRID)  # (7, 7, 7)
            place = torch.cat([row, column], -1)  # (7, 7, 14)
            cells = torch.cat([cells, place.expand(*cells.shape[:2], -1, -1, -1)], -1)
        return cells.flatten(2, 3)

    def _read(self, past: Tensor, text: Text) -> Tensor:
        """Return the words to which the past attends, (B, S, H)."""
        scores = torch.einsum("bsh,bth->bst", past, text.words)
        return _masked_softmax(scores, text.padding[:, None]) @ text.words

    def _seen_and_read(self, past: Tensor, seen: Tensor, text: Text) -> list[Tensor]:
        """Return cells and words, each in the light of the other, to which the past attends: twice (B, S, H).

        The paper fuses first, fused = W [own; other; own * other] + b for every cell and every word, then attends to
        what was fused. Nothing but sums lies between, so W can be moved past the attention, with equal results: the
        past goes through W once, instead of every cell and word at every step.
        """
        words, padding = text.words, text.padding[:, None]  # (B, T, H), (B, 1, T)
        alike = torch.einsum("bskh,bth->bskt", seen, words * self.similarity.weight[0]) + self.similarity.bias
        read_in = torch.einsum(
            "bskt,bth->bskh", _masked_softmax(alike, padding[:, None]), words
        )  # by each cell, (B, S, K, H)
        seen_in = alike.softmax(2).transpose(2, 3) @ seen  # by each word, (B, S, T, H)
        words = words[:, None].expand_as(seen_in)  # (B, S, T, H)
        return [
            self.fuse_cells(_attend(past @ self.fuse_cells.weight, (seen, read_in, seen * read_in))),
            self.fuse_words(_attend(past @ self.fuse_words.weight, (words, seen_in, words * seen_in), padding)),
        ]


class Model(nn.Module):
    """Both modules."""

    def __init__(self, config: ModelConfig) -> None:
        super().__init__()
        self.config = config
        self.modules_by_phase = nn.ModuleDict({phase: PhaseModel(config) for phase in PHASES})

    def of(self, phase: str) -> PhaseModel:
        """Return the module of a phase, "navigation" or "assembly"."""
        module = self.modules_by_phase[phase]
        assert isinstance(module, PhaseModel)
        return module


def as_input(features: npt.NDArray[np.uint8]) -> Tensor:
    """Return quantised features as input of the model, float32 in [0, 1]."""
    return torch.from_numpy(features).float() / 255.0


def _masked_softmax(scores: Tensor, padding: Tensor) -> Tensor:
    """Return weights over the last dimension that are 0 at padding."""
    return functional.softmax(scores.masked_fill(padding, -1e9), -1)


def _attend(past: Tensor, parts: Sequence[Tensor], padding: Tensor | None = None) -> Tensor:
    """Return those of N things to which the past attends.

    Args:
        past: a value for each number of a thing, (B, S, P H).
        parts: P times H numbers of each thing, (B, S, N, H).
        padding: things that are none, (B, 1, N).

    Returns:
        (B, S, P H).
    """
    by_part = past.chunk(len(parts), -1)
    scores = torch.stack([(part @ each[..., None])[..., 0] for part, each in zip(parts, by_part, strict=True)]).sum(0)
    weights = (scores.softmax(-1) if padding is None else _masked_softmax(scores, padding))[:, :, None]  # (B, S, 1, N)
    return torch.cat([(weights @ part)[:, :, 0] for part in parts], -1)
