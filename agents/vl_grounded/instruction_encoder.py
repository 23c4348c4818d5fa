"""Text encoder of both networks of `vl_grounded`: words in context, attention to them, and the names they mean.

In the comments B is the batch, T words, H = 192, R reads, N places, K, C and L kinds, colours and looks.
"""

from typing import NamedTuple

import torch
from torch import Tensor, nn

from arramon_agents.perception.eyes.vocabulary import COLOURS
from arramon_agents.vl_grounded.attributes import KINDS, LOOKS, Attributes

EMBEDDING, LSTM_HIDDEN = 64, 96
"""Size of a word's embedding, and of its context in each direction, as in the learned reader."""

HIDDEN = 2 * LSTM_HIDDEN
"""H: size of a word in context."""

PHRASE, MOVE = 5, 15
"""Width in words of an attention window, and how far it may move from one step to the next."""

UNKNOWN = 1
"""Id of unknown words."""

WORD_DROPOUT = 0.04
"""Share of words that are replaced by the unknown word in training."""

DROPOUT = 0.2


class AttributeProbabilities(NamedTuple):
    """Meaning of a read: probabilities of kinds (..., K + 1), colours (..., C + 1), looks (..., L + 1); last: none."""

    kinds: Tensor
    colours: Tensor
    looks: Tensor


class InstructionEncoder(nn.Module):
    """Encodes words in context, and predicts which kinds, colours and looks they name.

    Args:
        vocabulary: size of the tokenizer's vocabulary.
    """

    def __init__(self, vocabulary: int) -> None:
        super().__init__()
        self.words = nn.Embedding(vocabulary, EMBEDDING, padding_idx=0)
        self.phrases = nn.Conv1d(EMBEDDING, EMBEDDING, PHRASE, padding=PHRASE // 2)
        self.encoder = nn.LSTM(EMBEDDING, LSTM_HIDDEN, batch_first=True, bidirectional=True)
        self.names = nn.Linear(HIDDEN, len(KINDS) + len(COLOURS) + len(LOOKS) + 3)
        self.dropout = nn.Dropout(DROPOUT)

    def forward(self, tokens: Tensor) -> Tensor:
        """Return the encoded words of texts, (B, T, H), from word ids (B, T); 0 after a text's end."""
        is_word = tokens != 0
        if self.training:
            tokens = tokens.masked_fill(
                is_word & (torch.rand(tokens.shape, device=tokens.device) < WORD_DROPOUT), UNKNOWN
            )
        words = self.dropout(self.words(tokens))  # (B, T, E)
        phrases = nn.functional.relu(self.phrases(words.transpose(1, 2))).transpose(1, 2)
        words = words + phrases * is_word[:, :, None]
        packed = nn.utils.rnn.pack_padded_sequence(words, is_word.sum(1).cpu(), batch_first=True, enforce_sorted=False)
        read: Tensor = nn.utils.rnn.pad_packed_sequence(self.encoder(packed)[0], True, total_length=tokens.shape[1])[0]
        dropped: Tensor = self.dropout(read)
        return dropped

    def logits(self, read: Tensor) -> tuple[Tensor, ...]:
        """Return the logits of `AttributeProbabilities` for a read, (..., H)."""
        sizes = [len(KINDS) + 1, len(COLOURS) + 1, len(LOOKS) + 1]
        return torch.split(self.names(read), sizes, -1)

    def meant(self, read: Tensor) -> AttributeProbabilities:
        """Return the meaning of a read, (..., H)."""
        return AttributeProbabilities(*(logits.softmax(-1) for logits in self.logits(read)))


def match(meant: AttributeProbabilities, there: Attributes) -> Tensor:
    """Return how well the things in each place match each read, (B, R, N) in [0, 1]: kind, colour and look.

    Args:
        meant: of each of R reads, (B, R, ...).
        there: in each of N places, (B, N, ...).
    """
    kinds = meant.kinds[..., :-1] @ there.kinds.transpose(-1, -2)
    colours = meant.colours[..., :-1] @ there.colours.transpose(-1, -2) + meant.colours[..., -1:]
    looks = meant.looks[..., :-1] @ there.looks.transpose(-1, -2) + meant.looks[..., -1:]
    return kinds * colours * looks


def best_match(meant: AttributeProbabilities) -> Tensor:
    """Return the match of the most likely meaning, (B, R): below 1 where the meaning is uncertain."""
    kinds = meant.kinds[..., :-1].amax(-1)
    colours = meant.colours[..., :-1].amax(-1) + meant.colours[..., -1]
    looks = meant.looks[..., :-1].amax(-1) + meant.looks[..., -1]
    return kinds * colours * looks


class Attention(nn.Module):
    """Attends to words with R heads, given where each attended before: instructions are in order.

    (Location-aware attention, Chorowski et al. 2015.)

    Args:
        state: size of the query.
        reads: R.
    """

    def __init__(self, state: int, reads: int) -> None:
        super().__init__()
        self.reads = reads
        self.queries = nn.Linear(state, reads * HIDDEN)
        self.moves = nn.Conv1d(2 * reads, reads, MOVE, padding=MOVE // 2)

    def first(self, tokens: Tensor) -> Tensor:
        """Return the initial attention, (B, 2 R, T): at the first word."""
        looks = torch.zeros(len(tokens), 2 * self.reads, tokens.shape[1], device=tokens.device)
        looks[:, :, 0] = 1.0
        return looks

    def forward(self, state: Tensor, words: Tensor, padding: Tensor, looks: Tensor) -> tuple[Tensor, Tensor]:
        """Return the reads, (B, R, H), and the new attention: the last weights and their sums.

        Args:
            state: the query, (B, S).
            words: in context, (B, T, H).
            padding: which are none, (B, T).
            looks: the previous attention, (B, 2 R, T).
        """
        queries = self.queries(state).view(len(state), self.reads, HIDDEN)
        scores = queries @ words.transpose(1, 2) / HIDDEN**0.5 + self.moves(looks)  # (B, R, T)
        weights = scores.masked_fill(padding[:, None], -1e9).softmax(2)
        so_far = torch.clamp(looks[:, self.reads :] + weights, max=1.0)
        return weights @ words, torch.cat([weights, so_far], 1)
