"""Network of `vl_grounded` (shared text encoder, navigation and placement networks); saving and loading its weights."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from torch import nn

from arramon_agents.reading.tokenizers import TextTokenizer, restore_tokenizer
from arramon_agents.vl_grounded.instruction_encoder import InstructionEncoder
from arramon_agents.vl_grounded.navigation_network import GroundedNavigationNetwork
from arramon_agents.vl_grounded.placement_network import GroundedPlacementNetwork
from arramon_agents.weights import LARGEST, read_weights_file, write_weights_file

FORMAT = "vl_grounded 1"


class Grounded(nn.Module):
    """Navigation and placement networks with a shared text encoder. Attribute names are tensor names in weights.

    Args:
        vocabulary: vocabulary size of the tokenizer.
    """

    def __init__(self, vocabulary: int) -> None:
        super().__init__()
        self.vocabulary = vocabulary
        self.reading = InstructionEncoder(vocabulary)
        self.street = GroundedNavigationNetwork()
        self.room = GroundedPlacementNetwork()


@dataclass(frozen=True)
class GroundedWeights:
    """Content of a file of weights.

    Attributes:
        network: the network.
        tokenizer: tokenizer of instructions.
        eyes: fingerprint of the visual encoder used in training.
        about: metadata as JSON values.
    """

    network: Grounded
    tokenizer: TextTokenizer
    eyes: str
    about: Mapping[str, Any]


def write_weights(path: Path, weights: GroundedWeights) -> None:
    """Write weights to a file, atomically."""
    header = {
        "format": FORMAT,
        "vocabulary": weights.network.vocabulary,
        "tokenizer": weights.tokenizer.name,
        "eyes": weights.eyes,
        "about": dict(weights.about),
    }
    write_weights_file(path, {"": weights.network}, header, {"tokenizer": weights.tokenizer.dump()})


def read_weights(path: Path) -> GroundedWeights:
    """Return the weights of a file, in evaluation mode.

    Raises:
        BadWeights: if the file cannot be read.
    """
    file = read_weights_file(path, "agents.vl_grounded", FORMAT)
    tokenizer = restore_tokenizer(file.value("tokenizer", str), file.blob("tokenizer"))
    vocabulary = file.value("vocabulary", int)
    if not 1 <= vocabulary <= LARGEST:
        raise file.wrong(f"its header has the vocabulary {vocabulary}, expected 1 to {LARGEST}")
    network = file.build(lambda: Grounded(vocabulary))
    file.fill(network)
    network.requires_grad_(requires_grad=False)
    return GroundedWeights(network, tokenizer, file.value("eyes", str), file.value("about", dict))
