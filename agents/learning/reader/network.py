"""The reader's network: a two-layer LSTM in both directions over the words, and a decoder of rows of slots."""

from dataclasses import dataclass

import torch
from torch import Tensor, nn
from torch.nn import functional

from agents.learning.reader.slots import ACTION_SLOTS, MOST_ROWS, SLOTS, THING_SLOTS

PARTS = (ACTION_SLOTS, *THING_SLOTS)
"""Slots that look at the same words: what is done, the first thing, the second."""


@dataclass(frozen=True, slots=True)
class Sizes:
    """Sizes of the network.

    Attributes:
        words: numbers of the vocabulary.
        embedding: of a word, and of a slot's value.
        encoder: hidden units in each direction.
        decoder: hidden units.
        dropout: share of the inputs of each layer left out in training.
    """

    words: int
    embedding: int = 64
    encoder: int = 96
    decoder: int = 192
    dropout: float = 0.15


class ReaderNetwork(nn.Module):
    """Predicts the rows of a text, one after the other.

    Args:
        sizes: of the network.
    """

    def __init__(self, sizes: Sizes) -> None:
        super().__init__()
        self.sizes = sizes
        embedding, both, state = sizes.embedding, 2 * sizes.encoder, sizes.decoder
        self.words = nn.Embedding(sizes.words, embedding, padding_idx=0)
        self.encoder = nn.LSTM(embedding, sizes.encoder, 2, batch_first=True, bidirectional=True, dropout=sizes.dropout)
        self.start = nn.Linear(both, state)
        self.slots = nn.ModuleList(nn.Embedding(len(values), embedding) for values in SLOTS.values())
        self.decoder = nn.LSTM(embedding, state, batch_first=True)
        self.queries = nn.ModuleList(nn.Linear(state, both) for _ in PARTS)
        self.heads = nn.ModuleList(nn.Linear(state + both, len(values)) for values in SLOTS.values())
        self.dropout = nn.Dropout(sizes.dropout)

    def forward(self, texts: Tensor, rows: Tensor) -> dict[str, Tensor]:
        """Return the logits of every row by slot, (B, rows, values), each from the true rows before it.

        Args:
            texts: (B, words) numbers of words, 0 after a text's end.
            rows: (B, rows, slots) numbers of values.
        """
        memory, state = self._encode(texts)
        before = functional.pad(rows[:, :-1], (0, 0, 1, 0))
        hidden, _ = self.decoder(self._embed(before), state)
        return self._slots(hidden, memory, texts == 0)

    @torch.inference_mode()
    def read(self, texts: Tensor) -> Tensor:
        """Return the most likely rows of texts, (B, MOST_ROWS, slots); what follows an end has no meaning."""
        memory, state = self._encode(texts)
        row = torch.zeros(len(texts), 1, len(SLOTS), dtype=torch.long)
        rows = []
        for _ in range(MOST_ROWS):
            hidden, state = self.decoder(self._embed(row), state)
            found = self._slots(hidden, memory, texts == 0)
            row = torch.stack([found[name].argmax(2) for name in SLOTS], dim=2)
            rows.append(row)
            if bool((torch.cat(rows, 1)[:, :, 0] == 0).any(1).all()):
                break
        return torch.cat(rows, 1)

    def _encode(self, texts: Tensor) -> tuple[Tensor, tuple[Tensor, Tensor]]:
        """Return (B, words, 2 encoder) of the words, and the decoder's first state."""
        lengths = (texts != 0).sum(1)
        packed = nn.utils.rnn.pack_padded_sequence(
            self.dropout(self.words(texts)), lengths, batch_first=True, enforce_sorted=False
        )
        memory, _ = nn.utils.rnn.pad_packed_sequence(self.encoder(packed)[0], True, total_length=texts.shape[1])
        mean = memory.sum(1) / lengths[:, None]
        first = torch.tanh(self.start(mean))[None]
        return memory, (first, torch.zeros_like(first))

    def _embed(self, rows: Tensor) -> Tensor:
        embedded = torch.stack([slot(rows[:, :, number]) for number, slot in enumerate(self.slots)])
        dropped: Tensor = self.dropout(embedded.sum(0))
        return dropped

    def _slots(self, hidden: Tensor, memory: Tensor, is_filling: Tensor) -> dict[str, Tensor]:
        found: dict[str, Tensor] = {}
        heads = dict(zip(SLOTS, self.heads, strict=True))
        for names, query in zip(PARTS, self.queries, strict=True):
            match = query(hidden) @ memory.transpose(1, 2) / memory.shape[2] ** 0.5  # (B, rows, words)
            match = match.masked_fill(is_filling[:, None], float("-inf"))
            features = self.dropout(torch.cat([hidden, match.softmax(2) @ memory], 2))
            found |= {name: heads[name](features) for name in names}
        return found
