"""Text encoders of trained agents: from token ids, (B, T), padded with 0, to a vector per token, (B, T, H).

"lstm" is trained from scratch; `pretrained=SOURCE` uses the states of a frozen encoder. Attribute names of the modules
are tensor names in weights.
"""

from collections.abc import Sequence
from typing import cast

import torch
from torch import Tensor, nn

from arramon_agents.pretrained.hidden_state_cache import open_hidden_state_cache
from arramon_agents.reading.tokenizers import PAD, PRETRAINED, SPECIAL


class LstmTextEncoder(nn.Module):
    """Text encoder of the paper: word embedding and unidirectional LSTM."""

    def __init__(self, vocabulary: int, word_size: int, hidden: int) -> None:
        super().__init__()
        self.embedding = nn.Embedding(vocabulary, word_size)
        self.lstm = nn.LSTM(word_size, hidden, batch_first=True)

    def forward(self, tokens: Tensor) -> Tensor:
        """Return (B, T, H)."""
        return cast(Tensor, self.lstm(self.embedding(tokens))[0])


class PretrainedTextEncoder(nn.Module):
    """Two-layer perceptron on each state of a frozen encoder, which is not part of the weights.

    It is independent of word order, which differs between languages; the states are contextual already.

    Args:
        source: source of the frozen encoder, see `arramon_agents.pretrained.encoders`.
        hidden: hidden size of the output.
    """

    def __init__(self, source: str, hidden: int) -> None:
        super().__init__()
        self.states = open_hidden_state_cache(source)
        size = self.states.encoder.size
        self.narrow = nn.Sequential(nn.Linear(size, 2 * hidden), nn.GELU(), nn.Linear(2 * hidden, hidden))
        self.mean: Tensor
        self.deviation: Tensor
        self.register_buffer("mean", torch.zeros(size))
        self.register_buffer("deviation", torch.ones(size))

    def standardise(self, mean: Tensor, deviation: Tensor) -> None:
        """Set mean and standard deviation to standardise states, as pretrained states have a large common component."""
        for kept, given in ((self.mean, mean), (self.deviation, deviation)):
            kept.copy_(given)

    def forward(self, tokens: Tensor) -> Tensor:
        """Return (B, T, H)."""
        states = self.states.hidden_states([encoder_ids(row) for row in tokens.tolist()]).to(tokens.device)
        return cast(Tensor, self.narrow((states - self.mean) / self.deviation))


def encoder_ids(tokens: Sequence[int]) -> list[int]:
    """Convert tokenizer ids to the encoder's own ids, without padding; an unknown token becomes id 0."""
    return [max(number - SPECIAL, 0) for number in tokens if number != PAD]


LSTM = "lstm"


def make_text_encoder(name: str, vocabulary: int, word_size: int, hidden: int) -> nn.Module:
    """Return a text encoder by name: "lstm" or `pretrained=SOURCE`.

    Raises:
        ValueError: if there is no such text encoder, or its source is not available.
    """
    if name.startswith(PRETRAINED):
        return PretrainedTextEncoder(name.removeprefix(PRETRAINED), hidden)
    if name != LSTM:
        raise ValueError(f"there is no reader {name!r}; there are {LSTM} and {PRETRAINED}SOURCE")
    return LstmTextEncoder(vocabulary, word_size, hidden)
