"""What both networks of `vl_grounded` read by: words in context, and what is meant by those that are attended to.

In the comments B is the batch, T words, H = 192, R reads, N places, K, C and L kinds, colours and looks.
"""

from typing import NamedTuple

import torch
from torch import Tensor, nn

from agents.learning.eyes.vocabulary import COLOURS
from agents.vl_grounded.naming import KINDS, LOOKS, Named

EMBEDDING, HALF = 64, 96
"""Numbers of a word, and of a word in the context of what is on one side of it: as in the learned reader."""

WORD = 2 * HALF
"""H: numbers of a word in context."""

PHRASE, MOVE = 5, 15
"""Words that are looked at together, and words by which a look may move on from that before it."""

UNKNOWN = 1
"""Number of a word that is not known."""

UNREAD = 0.04
"""Share of the words that are made unknown in training."""

DROPOUT = 0.2


class Meant(NamedTuple):
    """What is meant: chances of kinds (..., K + 1), colours (..., C + 1) and looks (..., L + 1); the last is none."""

    kinds: Tensor
    colours: Tensor
    looks: Tensor


class Reading(nn.Module):
    """Reads words in context, and says which kinds, colours and looks they name.

    Args:
        vocabulary: numbers that the tokenizer gives.
    """

    def __init__(self, vocabulary: int) -> None:
        super().__init__()
        self.words = nn.Embedding(vocabulary, EMBEDDING, padding_idx=0)
        self.phrases = nn.Conv1d(EMBEDDING, EMBEDDING, PHRASE, padding=PHRASE // 2)
        self.encoder = nn.LSTM(EMBEDDING, HALF, batch_first=True, bidirectional=True)
        self.names = nn.Linear(WORD, len(KINDS) + len(COLOURS) + len(LOOKS) + 3)
        self.dropout = nn.Dropout(DROPOUT)

    def forward(self, tokens: Tensor) -> Tensor:
        """Return (B, T, H) of texts, (B, T) numbers of words with 0 after a text's end; 0 there."""
        is_word = tokens != 0
        if self.training:
            tokens = tokens.masked_fill(is_word & (torch.rand(tokens.shape, device=tokens.device) < UNREAD), UNKNOWN)
        words = self.dropout(self.words(tokens))  # (B, T, E)
        phrases = nn.functional.relu(self.phrases(words.transpose(1, 2))).transpose(1, 2)
        words = words + phrases * is_word[:, :, None]
        packed = nn.utils.rnn.pack_padded_sequence(words, is_word.sum(1).cpu(), batch_first=True, enforce_sorted=False)
        read: Tensor = nn.utils.rnn.pad_packed_sequence(self.encoder(packed)[0], True, total_length=tokens.shape[1])[0]
        dropped: Tensor = self.dropout(read)
        return dropped

    def logits(self, read: Tensor) -> tuple[Tensor, ...]:
        """Return the logits of `Meant` for what was read, (..., H)."""
        sizes = [len(KINDS) + 1, len(COLOURS) + 1, len(LOOKS) + 1]
        return torch.split(self.names(read), sizes, -1)

    def meant(self, read: Tensor) -> Meant:
        """Return what is meant by what was read, (..., H)."""
        return Meant(*(logits.softmax(-1) for logits in self.logits(read)))


def match(meant: Meant, there: Named) -> Tensor:
    """Return how well what is there fits what is meant, (B, R, N) in [0, 1]: its kind, its colour and its look.

    Args:
        meant: for each of R reads, (B, R, ...).
        there: in each of N places, (B, N, ...).
    """
    kinds = meant.kinds[..., :-1] @ there.kinds.transpose(-1, -2)
    colours = meant.colours[..., :-1] @ there.colours.transpose(-1, -2) + meant.colours[..., -1:]
    looks = meant.looks[..., :-1] @ there.looks.transpose(-1, -2) + meant.looks[..., -1:]
    return kinds * colours * looks


def best_match(meant: Meant) -> Tensor:
    """Return how well what is most likely meant would fit, (B, R): less than 1 as far as it is not certain what is."""
    kinds = meant.kinds[..., :-1].amax(-1)
    colours = meant.colours[..., :-1].amax(-1) + meant.colours[..., -1]
    looks = meant.looks[..., :-1].amax(-1) + meant.looks[..., -1]
    return kinds * colours * looks


class Attention(nn.Module):
    """Attends to words in R ways at once, knowing where it attended before: instructions are told in order.

    (Location-aware attention, Chorowski et al. 2015.)

    Args:
        state: numbers of the state that asks.
        reads: R.
    """

    def __init__(self, state: int, reads: int) -> None:
        super().__init__()
        self.reads = reads
        self.queries = nn.Linear(state, reads * WORD)
        self.moves = nn.Conv1d(2 * reads, reads, MOVE, padding=MOVE // 2)

    def first(self, tokens: Tensor) -> Tensor:
        """Return the looks before the first one, (B, 2 R, T): at the first word."""
        looks = torch.zeros(len(tokens), 2 * self.reads, tokens.shape[1], device=tokens.device)
        looks[:, :, 0] = 1.0
        return looks

    def forward(self, state: Tensor, words: Tensor, padding: Tensor, looks: Tensor) -> tuple[Tensor, Tensor]:
        """Return what is read, (B, R, H), and the looks after it: the last ones, and where it looked so far.

        Args:
            state: that asks, (B, S).
            words: in context, (B, T, H).
            padding: which are none, (B, T).
            looks: before, (B, 2 R, T).
        """
        queries = self.queries(state).view(len(state), self.reads, WORD)
        scores = queries @ words.transpose(1, 2) / WORD**0.5 + self.moves(looks)  # (B, R, T)
        weights = scores.masked_fill(padding[:, None], -1e9).softmax(2)
        so_far = torch.clamp(looks[:, self.reads :] + weights, max=1.0)
        return weights @ words, torch.cat([weights, so_far], 1)
