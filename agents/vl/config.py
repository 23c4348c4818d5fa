"""Sizes of the paper's model, and what it is given."""

from dataclasses import dataclass


@dataclass(frozen=True)
class ModelConfig:
    """Sizes of a model; the defaults are the original's.

    Attributes:
        vocabulary: numbers that a tokenizer gives, 0 for padding included.
        channels: features of a cell, without its position.
        sees: whether the image is used.
        reads: whether the instruction is used.
        positions: whether each cell's row and column are features too, as an encoder of single cells needs.
        reader: of the words, a name in `arramon_agents.reading.text_encoders`.
        word_size: numbers that stand for a word.
        action_size: numbers that stand for an action.
        hidden: size H of everything else.
        dropout: share of the action embedding and of the output's input that is dropped in training.
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
