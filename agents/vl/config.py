"""Configuration of the paper's model: its inputs and sizes."""

from dataclasses import dataclass


@dataclass(frozen=True)
class ModelConfig:
    """Inputs and sizes of a model; the default sizes are the paper's. Field names are keys in files of weights.

    Attributes:
        vocabulary: vocabulary size, padding included.
        channels: features of an image cell, C, without its position.
        sees: whether the image is an input.
        reads: whether the instruction is an input.
        positions: whether a cell's row and column are features too, for encoders that encode cells one by one.
        reader: name of the text encoder, see `arramon_agents.reading.text_encoders`.
        word_size: word embedding size.
        action_size: action embedding size.
        hidden: hidden size H of all other layers.
        dropout: dropout probability of the action embedding and of the output layer's input.
    """

    vocabulary: int = 774
    channels: int = 2048
    sees: bool = True
    reads: bool = True
    positions: bool = False
    reader: str = "lstm"
    word_size: int = 300
    action_size: int = 64
    hidden: int = 128
    dropout: float = 0.3
