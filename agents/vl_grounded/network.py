"""The networks of `vl_grounded` as one: what is read by both, what walks, and what places."""

from torch import nn

from agents.vl_grounded.reading import Reading
from agents.vl_grounded.room import RoomReader
from agents.vl_grounded.street import Street


class Grounded(nn.Module):
    """Both policies, which share how words are read and what they name.

    Args:
        vocabulary: numbers that the tokenizer gives.
    """

    def __init__(self, vocabulary: int) -> None:
        super().__init__()
        self.vocabulary = vocabulary
        self.reading = Reading(vocabulary)
        self.street = Street()
        self.room = RoomReader()
