"""The networks of `vl_grounded` in one module: the shared text encoder, the walking network, the placing network."""

from torch import nn

from arramon_agents.vl_grounded.reading import Reading
from arramon_agents.vl_grounded.room import RoomReader
from arramon_agents.vl_grounded.street import Street


class Grounded(nn.Module):
    """Both policies, with a shared text encoder.

    Args:
        vocabulary: size of the tokenizer's vocabulary.
    """

    def __init__(self, vocabulary: int) -> None:
        super().__init__()
        self.vocabulary = vocabulary
        self.reading = Reading(vocabulary)
        self.street = Street()
        self.room = RoomReader()
