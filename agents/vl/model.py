"""The paper's models (section 5): vision and language, vision only, language only.

One network per phase (navigation, assembly), of the same architecture and without shared weights. A text encoder (LSTM)
encodes the instruction, a second LSTM the agent's past actions (its history); of the images only the current one is
seen. Words and image cells attend to each other, and the history state attends to both. With the paper's sizes (774
words, 2,048 ResNet features) the three models have 1.83, 0.73 and 1.11 million parameters.

Shapes in comments: B batch size, S steps, T tokens, K = 49 image cells, C features of a cell, H hidden size (128).
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
"""Id of the "previous action" at the first step. As in the paper's code, it has an output logit, which is never the
target."""


class EncodedText(NamedTuple):
    """A batch of encoded instructions: hidden states of the words, (B, T, H), and the padding mask, (B, T)."""

    words: Tensor
    padding: Tensor

    def of(self, rows: Sequence[int]) -> "EncodedText":
        """Return the instructions at these indices of the batch."""
        return EncodedText(self.words[list(rows)], self.padding[list(rows)])


State = tuple[Tensor, Tensor]
"""Hidden and cell state of the history LSTM, (1, B, H) each."""


class PhaseModel(nn.Module):
    """Policy network of one phase. Its attribute names are tensor names in the shipped weights."""

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

    def read(self, tokens: Tensor) -> EncodedText:
        """Encode instructions, (B, T) token ids, 0 for padding. Without a text encoder the words have 0 features."""
        padding = tokens == 0  # (B, T)
        words = self.reader(tokens) if self.config.reads else tokens.new_zeros(*tokens.shape, 0).float()
        return EncodedText(words, padding)

    def act(
        self,
        text: EncodedText,
        cells: Tensor,
        previous_actions: Tensor,
        state: State | None = None,
        selected_steps: Tensor | None = None,
    ) -> tuple[Tensor, State]:
        """Return the action logits at S consecutive steps, (B, S, 5), and the history state after them.

        Args:
            text: the encoded instructions.
            cells: image features, (B, S, 7, 7, C), in [0, 1].
            previous_actions: the action before each step, (B, S); START_ACTION before the first.
            state: history state before these steps; None at the start of a phase.
            selected_steps: (B, L) indices of the steps to return logits for, with L < S; `cells` then has the images of
                these steps alone. None for all steps.
        """
        history, state = self.history(self.dropout(self.act_embedding(previous_actions)), state)  # (B, S, H)
        if selected_steps is not None:
            history = history.gather(1, selected_steps[:, :, None].expand(-1, -1, history.shape[2]))  # (B, L, H)
        features = [history]
        if self.config.sees:
            seen = self.look(self._with_positions(cells))  # (B, S, K, H)
            if self.config.reads:
                features += self._attend_to_both(history, seen, text)  # cells, words: (B, S, H) each
            else:
                features.append(_attend(history, (seen,)))  # (B, S, H)
        elif self.config.reads:
            features.append(self._attend_to_words(history, text))  # (B, S, H)
        return self.output(self.dropout(torch.cat(features, -1))), state

    def _with_positions(self, cells: Tensor) -> Tensor:
        """Flatten cells to (B, S, K, C); if configured, append one-hot row and column (14 features)."""
        if self.config.positions:
            one_hot = torch.eye(GRID, device=cells.device)
            row = one_hot[:, None].expand(GRID, GRID, GRID)  # (7, 7, 7)
            column = one_hot[None].expand(GRID, GRID, GRID)  # (7, 7, 7)
            place = torch.cat([row, column], -1)  # (7, 7, 14)
            cells = torch.cat([cells, place.expand(*cells.shape[:2], -1, -1, -1)], -1)
        return cells.flatten(2, 3)

    def _attend_to_words(self, history: Tensor, text: EncodedText) -> Tensor:
        """Return attention over the words, queried by the history state, (B, S, H)."""
        scores = torch.einsum("bsh,bth->bst", history, text.words)
        return _masked_softmax(scores, text.padding[:, None]) @ text.words

    def _attend_to_both(self, history: Tensor, seen: Tensor, text: EncodedText) -> list[Tensor]:
        """Return co-attention over cells and words, queried by the history state: (B, S, H) each.

        The paper first fuses each cell with the words that it attends to, and each word with its cells,
        fused = W [own; other; own * other] + b, and then attends over the fused vectors. Both steps are linear, so W
        is applied to the query and to the attended sum instead of to every cell and word: equal results, less work.
        """
        words, padding = text.words, text.padding[:, None]  # (B, T, H), (B, 1, T)
        similarity = torch.einsum("bskh,bth->bskt", seen, words * self.similarity.weight[0]) + self.similarity.bias
        cell_weights = _masked_softmax(similarity, padding[:, None])  # (B, S, K, T)
        words_of_cell = torch.einsum("bskt,bth->bskh", cell_weights, words)  # (B, S, K, H)
        cells_of_word = similarity.softmax(2).transpose(2, 3) @ seen  # (B, S, T, H)
        words = words[:, None].expand_as(cells_of_word)  # (B, S, T, H)
        cell_parts = seen, words_of_cell, seen * words_of_cell
        word_parts = words, cells_of_word, words * cells_of_word
        return [
            self.fuse_cells(_attend(history @ self.fuse_cells.weight, cell_parts)),
            self.fuse_words(_attend(history @ self.fuse_words.weight, word_parts, padding)),
        ]


class Model(nn.Module):
    """The models of both phases."""

    def __init__(self, config: ModelConfig) -> None:
        super().__init__()
        self.config = config
        self.modules_by_phase = nn.ModuleDict({phase: PhaseModel(config) for phase in PHASES})

    def of(self, phase: str) -> PhaseModel:
        """Return the model of a phase, "navigation" or "assembly"."""
        module = self.modules_by_phase[phase]
        assert isinstance(module, PhaseModel)
        return module


def as_input(features: npt.NDArray[np.uint8]) -> Tensor:
    """Convert quantised features to the model's input, float32 in [0, 1]."""
    return torch.from_numpy(features).float() / 255.0


def _masked_softmax(scores: Tensor, padding: Tensor) -> Tensor:
    """Masked softmax over the last dimension: weights are 0 where the padding mask is set."""
    return functional.softmax(scores.masked_fill(padding, -1e9), -1)


def _attend(query: Tensor, parts: Sequence[Tensor], padding: Tensor | None = None) -> Tensor:
    """Dot-product attention over N items, queried by the history state.

    Args:
        query: (B, S, P H).
        parts: features of the items in P parts, (B, S, N, H) each; keys and values are their concatenation.
        padding: padding mask of the items, (B, 1, N).

    Returns:
        The weighted sum of the items, (B, S, P H).
    """
    queries = query.chunk(len(parts), -1)  # P times (B, S, H)
    scores = torch.stack([(part @ each[..., None])[..., 0] for part, each in zip(parts, queries, strict=True)]).sum(0)
    weights = (scores.softmax(-1) if padding is None else _masked_softmax(scores, padding))[:, :, None]  # (B, S, 1, N)
    return torch.cat([(weights @ part)[:, :, 0] for part in parts], -1)
