"""Network of the learned reader: bidirectional LSTM encoder, and a decoder with location-aware attention."""

from dataclasses import dataclass

import torch
from torch import Tensor, nn
from torch.nn import functional

from arramon_agents.reading.reader.slots import ACTION_SLOTS, MAX_ROWS, SLOTS, THING_SLOTS
from arramon_agents.reading.reader.spelling import BUCKETS, MAX_NGRAMS

PARTS = (ACTION_SLOTS, *THING_SLOTS)
"""Groups of slots, each with an attention head: the action, the first thing, the second thing."""

EMBEDDING_KERNEL, ATTENTION_KERNEL = 5, 15
"""Kernel widths, in words: of the convolution over embeddings, and of the one over the previous attention weights."""

SPELLING_HIDDEN = 128
"""Hidden size of the layers over the mean embedding of a word's n-grams."""

State = tuple[Tensor, Tensor, Tensor, Tensor]
"""Hidden and cell state of the decoder, context vectors, and attention (B, 2 parts, words): last weights and sums."""


@dataclass(frozen=True, slots=True)
class ReaderSizes:
    """Sizes of the network. Field names are keys in files of weights.

    Attributes:
        words: vocabulary size.
        embedding: embedding size of words and of slot values.
        encoder: hidden size of the encoder in each direction.
        decoder: hidden size of the decoder.
        dropout: dropout probability.
    """

    words: int
    embedding: int = 64
    encoder: int = 96
    decoder: int = 192
    dropout: float = 0.15


class ReaderNetwork(nn.Module):
    """Decodes the rows of a text one by one.

    Each part of a row has an attention head, whose scores depend on the attention of the previous row, as instructions
    are in order (location-aware attention, Chorowski et al. 2015). Attribute names are tensor names in weights.

    Args:
        sizes: sizes of the network.
    """

    def __init__(self, sizes: ReaderSizes) -> None:
        super().__init__()
        self.sizes = sizes
        embedding, both, state = sizes.embedding, 2 * sizes.encoder, sizes.decoder
        self.words = nn.Embedding(sizes.words, embedding, padding_idx=0)
        self.ngrams = nn.EmbeddingBag(BUCKETS + 1, embedding, mode="mean", padding_idx=0)
        self.spelling = nn.Sequential(
            nn.Linear(embedding, SPELLING_HIDDEN), nn.ReLU(), nn.Linear(SPELLING_HIDDEN, embedding)
        )
        self.phrases = nn.Conv1d(embedding, embedding, EMBEDDING_KERNEL, padding=EMBEDDING_KERNEL // 2)
        self.encoder = nn.LSTM(embedding, sizes.encoder, batch_first=True, bidirectional=True)
        self.start = nn.Linear(both, state)
        self.slots = nn.ModuleList(nn.Embedding(len(values), embedding) for values in SLOTS.values())
        self.decoder = nn.LSTMCell(embedding + len(PARTS) * both, state)
        self.queries = nn.Linear(state, len(PARTS) * both)
        self.moves = nn.Conv1d(2 * len(PARTS), len(PARTS), ATTENTION_KERNEL, padding=ATTENTION_KERNEL // 2)
        self.heads = nn.ModuleList(nn.Linear(state + both, len(values)) for values in SLOTS.values())
        self.dropout = nn.Dropout(sizes.dropout)

    def forward(self, texts: Tensor, rows: Tensor) -> dict[str, Tensor]:
        """Return the logits of all rows by slot, (B, rows, values), with teacher forcing.

        Args:
            texts: codes of words, (B, words, CODE_SIZE), padded with 0.
            rows: value ids of the target rows, (B, rows, slots).
        """
        is_filling = texts[:, :, 0] == 0
        memory = self._encode(texts)
        state = self._first(is_filling, memory)
        before = self._embed(functional.pad(rows[:, :-1], (0, 0, 1, 0)))
        features = []
        for number in range(rows.shape[1]):
            state, found = self._step(before[:, number], state, memory, is_filling)
            features.append(found)
        return self._slots(torch.stack(features, dim=1))

    @torch.inference_mode()
    def read(self, texts: Tensor) -> Tensor:
        """Decode texts greedily to rows, (B, rows, slots); rows after an end row are meaningless."""
        is_filling = texts[:, :, 0] == 0
        memory = self._encode(texts)
        state = self._first(is_filling, memory)
        row = torch.zeros(len(texts), 1, len(SLOTS), dtype=torch.long, device=texts.device)
        rows = []
        for _ in range(MAX_ROWS):
            state, found = self._step(self._embed(row)[:, 0], state, memory, is_filling)
            logits = self._slots(found[:, None])
            row = torch.stack([logits[name].argmax(2) for name in SLOTS], dim=2)
            rows.append(row)
            if bool((torch.cat(rows, 1)[:, :, 0] == 0).any(1).all()):
                break
        return torch.cat(rows, 1)

    def embed_words(self, codes: Tensor) -> Tensor:
        """Return the embeddings of words from their codes: (..., CODE_SIZE) to (..., embedding)."""
        of_spelling: Tensor = self.spelling(self.ngrams(codes[..., 1:].reshape(-1, MAX_NGRAMS)))
        of_id: Tensor = self.words(codes[..., 0])
        return of_id + of_spelling.view_as(of_id)

    def _encode(self, texts: Tensor) -> Tensor:
        """Return the encoded words, (B, words, 2 encoder), 0 at padding."""
        is_word = (texts[:, :, 0] != 0)[:, :, None]
        words = self.dropout(self.embed_words(texts)) * is_word
        words = words + functional.relu(self.phrases(words.transpose(1, 2))).transpose(1, 2) * is_word
        lengths = is_word.sum((1, 2)).cpu()
        packed = nn.utils.rnn.pack_padded_sequence(words, lengths, batch_first=True, enforce_sorted=False)
        memory: Tensor = nn.utils.rnn.pad_packed_sequence(self.encoder(packed)[0], True, total_length=texts.shape[1])[0]
        return memory

    def _first(self, is_filling: Tensor, memory: Tensor) -> State:
        """Return the decoder's state before the first row."""
        mean = memory.sum(1) / (~is_filling).sum(1, keepdim=True)
        hidden = torch.tanh(self.start(mean))
        looks = memory.new_zeros(len(memory), 2 * len(PARTS), memory.shape[1])
        looks[:, :, 0] = 1.0
        return hidden, torch.zeros_like(hidden), memory.new_zeros(len(memory), len(PARTS) * memory.shape[2]), looks

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
        """Return logits by slot from features, (B, rows, parts, decoder + 2 encoder)."""
        features = self.dropout(features)
        heads = dict(zip(SLOTS, self.heads, strict=True))
        return {name: heads[name](features[:, :, part]) for part, names in enumerate(PARTS) for name in names}
