"""The reader's network: a convolution and an LSTM in both directions over the words, and a decoder of rows of slots."""

from dataclasses import dataclass

import torch
from torch import Tensor, nn
from torch.nn import functional

from arramon_agents.reading.reader.slots import ACTION_SLOTS, MOST_ROWS, SLOTS, THING_SLOTS

PARTS = (ACTION_SLOTS, *THING_SLOTS)
"""Groups of slots that attend to the same words: the action, the first thing, the second thing."""

PHRASE, MOVE = 5, 15
"""Width in words of an attention window, and how far it may move from that of the previous row."""

State = tuple[Tensor, Tensor, Tensor, Tensor]
"""The decoder's hidden and cell state, the attended words, and attention (B, 2 parts, words): last and summed."""


@dataclass(frozen=True, slots=True)
class ReaderSizes:
    """Sizes of the network.

    Attributes:
        words: size of the vocabulary.
        embedding: size of the embedding of a word, and of a slot's value.
        encoder: hidden units in each direction.
        decoder: hidden units.
        dropout: probability of dropping an input of a layer in training.
    """

    words: int
    embedding: int = 64
    encoder: int = 96
    decoder: int = 192
    dropout: float = 0.15


class ReaderNetwork(nn.Module):
    """Predicts the rows of a text one by one.

    Each part of a row attends to the words anew, given where the previous row attended: instructions are in order
    (location-aware attention, Chorowski et al. 2015).

    Args:
        sizes: of the network.
    """

    def __init__(self, sizes: ReaderSizes) -> None:
        super().__init__()
        self.sizes = sizes
        embedding, both, state = sizes.embedding, 2 * sizes.encoder, sizes.decoder
        self.words = nn.Embedding(sizes.words, embedding, padding_idx=0)
        self.phrases = nn.Conv1d(embedding, embedding, PHRASE, padding=PHRASE // 2)
        self.encoder = nn.LSTM(embedding, sizes.encoder, batch_first=True, bidirectional=True)
        self.start = nn.Linear(both, state)
        self.slots = nn.ModuleList(nn.Embedding(len(values), embedding) for values in SLOTS.values())
        self.decoder = nn.LSTMCell(embedding + len(PARTS) * both, state)
        self.queries = nn.Linear(state, len(PARTS) * both)
        self.moves = nn.Conv1d(2 * len(PARTS), len(PARTS), MOVE, padding=MOVE // 2)
        self.heads = nn.ModuleList(nn.Linear(state + both, len(values)) for values in SLOTS.values())
        self.dropout = nn.Dropout(sizes.dropout)

    def forward(self, texts: Tensor, rows: Tensor) -> dict[str, Tensor]:
        """Return the logits of every row by slot, (B, rows, values), by teacher forcing.

        Args:
            texts: (B, words) word ids, 0 after a text's end.
            rows: (B, rows, slots) value ids.
        """
        memory = self._encode(texts)
        state = self._first(texts, memory)
        before = self._embed(functional.pad(rows[:, :-1], (0, 0, 1, 0)))
        features = []
        for number in range(rows.shape[1]):
            state, found = self._step(before[:, number], state, memory, texts == 0)
            features.append(found)
        return self._slots(torch.stack(features, dim=1))

    @torch.inference_mode()
    def read(self, texts: Tensor) -> Tensor:
        """Return the most likely rows of texts by greedy decoding, (B, rows, slots); ignore what follows an end."""
        memory = self._encode(texts)
        state = self._first(texts, memory)
        row = torch.zeros(len(texts), 1, len(SLOTS), dtype=torch.long)
        rows = []
        for _ in range(MOST_ROWS):
            state, found = self._step(self._embed(row)[:, 0], state, memory, texts == 0)
            logits = self._slots(found[:, None])
            row = torch.stack([logits[name].argmax(2) for name in SLOTS], dim=2)
            rows.append(row)
            if bool((torch.cat(rows, 1)[:, :, 0] == 0).any(1).all()):
                break
        return torch.cat(rows, 1)

    def _encode(self, texts: Tensor) -> Tensor:
        """Return the encoded words, (B, words, 2 encoder); 0 after a text's end."""
        is_word = (texts != 0)[:, :, None]
        words = self.dropout(self.words(texts))
        words = words + functional.relu(self.phrases(words.transpose(1, 2))).transpose(1, 2) * is_word
        packed = nn.utils.rnn.pack_padded_sequence(words, is_word.sum((1, 2)), batch_first=True, enforce_sorted=False)
        memory: Tensor = nn.utils.rnn.pad_packed_sequence(self.encoder(packed)[0], True, total_length=texts.shape[1])[0]
        return memory

    def _first(self, texts: Tensor, memory: Tensor) -> State:
        """Return the decoder's state before the first row."""
        mean = memory.sum(1) / (texts != 0).sum(1, keepdim=True)
        hidden = torch.tanh(self.start(mean))
        looks = torch.zeros(len(texts), 2 * len(PARTS), texts.shape[1])
        looks[:, :, 0] = 1.0
        return hidden, torch.zeros_like(hidden), torch.zeros(len(texts), len(PARTS) * memory.shape[2]), looks

    def _step(self, before: Tensor, state: State, memory: Tensor, is_filling: Tensor) -> tuple[State, Tensor]:
        """Return the state after a row, and the features of each of its parts, (B, parts, decoder + 2 encoder)."""
        hidden, cell, contexts, looks = state
        hidden, cell = self.decoder(torch.cat([before, contexts], 1), (hidden, cell))
        queries = self.queries(hidden).view(len(hidden), len(PARTS), -1)
        match = queries @ memory.transpose(1, 2) / memory.shape[2] ** 0.5 + self.moves(looks)  # (B, parts, words)
        weights = match.masked_fill(is_filling[:, None], float("-inf")).softmax(2)
        found = weights @ memory
        so_far = torch.clamp(looks[:, len(PARTS) :] + weights, max=1.0)
        features = torch.cat([hidden[:, None].expand(-1, len(PARTS), -1), found], 2)
        return (hidden, cell, found.flatten(1), torch.cat([weights, so_far], 1)), features

    def _embed(self, rows: Tensor) -> Tensor:
        embedded = torch.stack([slot(rows[:, :, number]) for number, slot in enumerate(self.slots)])
        dropped: Tensor = self.dropout(embedded.sum(0))
        return dropped

    def _slots(self, features: Tensor) -> dict[str, Tensor]:
        """Return logits by slot of features, (B, rows, parts, decoder + 2 encoder)."""
        features = self.dropout(features)
        heads = dict(zip(SLOTS, self.heads, strict=True))
        return {name: heads[name](features[:, :, part]) for part, names in enumerate(PARTS) for name in names}
