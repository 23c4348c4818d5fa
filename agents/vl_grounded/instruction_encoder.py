"""Text encoder shared by both networks of `vl_grounded`, attention over its words, and a head that predicts attributes.

Shapes in comments: B batch size, T tokens, H hidden size (192), R attention heads, N places (image or room cells), and
K kinds, C colours, L looks.
"""

from typing import NamedTuple

import torch
from torch import Tensor, nn

from arramon_agents.perception.eyes.vocabulary import COLOURS
from arramon_agents.vl_grounded.attributes import KINDS, LOOKS, Attributes

EMBEDDING, LSTM_HIDDEN = 64, 96
"""Word embedding size, and hidden size of the LSTM in each direction; both as in the learned reader."""

HIDDEN = 2 * LSTM_HIDDEN
"""Hidden size H of an encoded word."""

PHRASE, MOVE = 5, 15
"""Kernel widths, in words: of the convolution over embeddings, and of the one over the previous attention weights."""

UNKNOWN = 1
"""Id of unknown words."""

WORD_DROPOUT = 0.04
"""Probability of replacing a word by the unknown word in training."""

DROPOUT = 0.2


class AttributeProbabilities(NamedTuple):
    """Attributes that words name: probabilities of kinds (..., K + 1), colours (..., C + 1) and looks (..., L + 1).

    The last class of each is "not named".
    """

    kinds: Tensor
    colours: Tensor
    looks: Tensor


class InstructionEncoder(nn.Module):
    """Encodes words in context, and predicts which kinds, colours and looks they name.

    Its attribute names are tensor names in the shipped weights.

    Args:
        vocabulary: vocabulary size of the tokenizer.
    """

    def __init__(self, vocabulary: int) -> None:
        super().__init__()
        self.words = nn.Embedding(vocabulary, EMBEDDING, padding_idx=0)
        self.phrases = nn.Conv1d(EMBEDDING, EMBEDDING, PHRASE, padding=PHRASE // 2)
        self.encoder = nn.LSTM(EMBEDDING, LSTM_HIDDEN, batch_first=True, bidirectional=True)
        self.names = nn.Linear(HIDDEN, len(KINDS) + len(COLOURS) + len(LOOKS) + 3)
        self.dropout = nn.Dropout(DROPOUT)

    def forward(self, tokens: Tensor) -> Tensor:
        """Encode texts: (B, T, H) from token ids (B, T); 0 at padding."""
        is_word = tokens != 0
        if self.training:
            tokens = tokens.masked_fill(
                is_word & (torch.rand(tokens.shape, device=tokens.device) < WORD_DROPOUT), UNKNOWN
            )
        words = self.dropout(self.words(tokens))  # (B, T, E)
        phrases = nn.functional.relu(self.phrases(words.transpose(1, 2))).transpose(1, 2)
        words = words + phrases * is_word[:, :, None]
        packed = nn.utils.rnn.pack_padded_sequence(words, is_word.sum(1).cpu(), batch_first=True, enforce_sorted=False)
        encoded: Tensor = nn.utils.rnn.pad_packed_sequence(self.encoder(packed)[0], True, total_length=tokens.shape[1])[
            0
        ]
        dropped: Tensor = self.dropout(encoded)
        return dropped

    def logits(self, context: Tensor) -> tuple[Tensor, ...]:
        """Return the logits of kinds, colours and looks (see `AttributeProbabilities`) of context vectors, (..., H)."""
        sizes = [len(KINDS) + 1, len(COLOURS) + 1, len(LOOKS) + 1]
        return torch.split(self.names(context), sizes, -1)

    def probabilities(self, context: Tensor) -> AttributeProbabilities:
        """Return the attributes that context vectors, (..., H), name."""
        return AttributeProbabilities(*(logits.softmax(-1) for logits in self.logits(context)))


def match(named: AttributeProbabilities, seen: Attributes) -> Tensor:
    """Return how well what is seen in each place matches what each head's words name, (B, R, N) in [0, 1].

    The match is the product of those of kind, colour and look.

    Args:
        named: attributes named by the words of each of R heads, (B, R, ...).
        seen: attributes seen in each of N places, (B, N, ...).
    """
    kinds = named.kinds[..., :-1] @ seen.kinds.transpose(-1, -2)
    colours = named.colours[..., :-1] @ seen.colours.transpose(-1, -2) + named.colours[..., -1:]
    looks = named.looks[..., :-1] @ seen.looks.transpose(-1, -2) + named.looks[..., -1:]
    return kinds * colours * looks


def best_match(named: AttributeProbabilities) -> Tensor:
    """Return the highest possible match, that of the most likely attributes, (B, R): below 1 if they are uncertain."""
    kinds = named.kinds[..., :-1].amax(-1)
    colours = named.colours[..., :-1].amax(-1) + named.colours[..., -1]
    looks = named.looks[..., :-1].amax(-1) + named.looks[..., -1]
    return kinds * colours * looks


class Attention(nn.Module):
    """Location-aware attention with R heads (Chorowski et al. 2015): scores depend on the previous attention weights.

    Instructions are carried out in order, so attention moves on from word to word.

    Args:
        state: size of the query.
        heads: number of heads, R.
    """

    def __init__(self, state: int, heads: int) -> None:
        super().__init__()
        self.heads = heads
        self.queries = nn.Linear(state, heads * HIDDEN)
        self.moves = nn.Conv1d(2 * heads, heads, MOVE, padding=MOVE // 2)

    def initial(self, tokens: Tensor) -> Tensor:
        """Return the initial attention, (B, 2 R, T): all weight on the first word."""
        attention = torch.zeros(len(tokens), 2 * self.heads, tokens.shape[1], device=tokens.device)
        attention[:, :, 0] = 1.0
        return attention

    def forward(self, state: Tensor, words: Tensor, padding: Tensor, attention: Tensor) -> tuple[Tensor, Tensor]:
        """Return the context vectors, (B, R, H), and the new attention: weights, and their sums over steps.

        Args:
            state: the query, (B, S).
            words: encoded words, (B, T, H).
            padding: padding mask, (B, T).
            attention: the previous attention, (B, 2 R, T).
        """
        queries = self.queries(state).view(len(state), self.heads, HIDDEN)
        scores = queries @ words.transpose(1, 2) / HIDDEN**0.5 + self.moves(attention)  # (B, R, T)
        weights = scores.masked_fill(padding[:, None], -1e9).softmax(2)
        summed = torch.clamp(attention[:, self.heads :] + weights, max=1.0)
        return weights @ words, torch.cat([weights, summed], 1)
