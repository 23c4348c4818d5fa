"""Text encoders of trained agents (readers): token ids (B, T) to one vector for each token (B, T, H). 0 is padding.

"lstm" is trained from scratch; `pretrained=SOURCE` uses the states of a frozen encoder.
"""

from collections.abc import Sequence
from typing import cast

import torch
from torch import Tensor, nn

from arramon_agents.pretrained.states import open_states
from arramon_agents.reading.tokenizers import PAD, PRETRAINED, SPECIAL


class LstmTextEncoder(nn.Module):
    """The paper's reader: an embedding and one LSTM from left to right."""

    def __init__(self, vocabulary: int, word_size: int, hidden: int) -> None:
        super().__init__()
        self.embedding = nn.Embedding(vocabulary, word_size)
        self.lstm = nn.LSTM(word_size, hidden, batch_first=True)

    def forward(self, tokens: Tensor) -> Tensor:
        """Return (B, T, H)."""
        return cast(Tensor, self.lstm(self.embedding(tokens))[0])


class PretrainedTextEncoder(nn.Module):
    """Two layers on each state of a frozen encoder; the encoder is not part of the weights.

    Nothing here depends on word order, which differs between languages: the states are contextual already.

    Args:
        source: of the encoder, see `arramon_agents.pretrained.encoders`.
        hidden: size of the output.
    """

    def __init__(self, source: str, hidden: int) -> None:
        super().__init__()
        self.states = open_states(source)
        size = self.states.encoder.size
        self.narrow = nn.Sequential(nn.Linear(size, 2 * hidden), nn.GELU(), nn.Linear(2 * hidden, hidden))
        self.mean: Tensor
        self.deviation: Tensor
        self.register_buffer("mean", torch.zeros(size))
        self.register_buffer("deviation", torch.ones(size))

    def standardise(self, mean: Tensor, deviation: Tensor) -> None:
        """Set the mean and standard deviation for standardising states: pretrained states are much alike."""
        for kept, given in ((self.mean, mean), (self.deviation, deviation)):
            kept.copy_(given)

    def forward(self, tokens: Tensor) -> Tensor:
        """Return (B, T, H)."""
        states = self.states.of([encoder_ids(row) for row in tokens.tolist()]).to(tokens.device)
        return cast(Tensor, self.narrow((states - self.mean) / self.deviation))


def encoder_ids(tokens: Sequence[int]) -> list[int]:
    """Return the encoder's own token ids; an unknown token, as in an empty text, becomes its first one."""
    return [max(number - SPECIAL, 0) for number in tokens if number != PAD]


LSTM = "lstm"


def make_text_encoder(name: str, vocabulary: int, word_size: int, hidden: int) -> nn.Module:
    """Return a reader by name: "lstm" or `pretrained=SOURCE`.

    Raises:
        ValueError: if there is no such reader, or its source is not available.
    """
    if name.startswith(PRETRAINED):
        return PretrainedTextEncoder(name.removeprefix(PRETRAINED), hidden)
    if name != LSTM:
        raise ValueError(f"there is no reader {name!r}; there are {LSTM} and {PRETRAINED}SOURCE")
    return LstmTextEncoder(vocabulary, word_size, hidden)
