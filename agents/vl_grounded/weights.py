"""Files of the networks' weights: safetensors in half precision, with the tokenizer beside them."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import torch

from arramon_agents.reading.tokenizers import Tokenizer, restore_tokenizer
from arramon_agents.vl_grounded.network import Grounded
from arramon_agents.weights import BadWeights, read_tensors, write_tensors

FORMAT = "vl_grounded 1"

_TOKENIZER = "tokenizer"


@dataclass(frozen=True)
class Weights:
    """Content of a weight file.

    Attributes:
        network: the networks.
        tokenizer: of instructions.
        eyes: fingerprint of the visual encoder used in training.
        about: metadata, as JSON values.
    """

    network: Grounded
    tokenizer: Tokenizer
    eyes: str
    about: Mapping[str, Any]


def write_weights(path: Path, weights: Weights) -> None:
    """Write weights to a file, atomically."""
    tensors = {
        name: value.detach().to(torch.float16).contiguous() for name, value in weights.network.state_dict().items()
    }
    tensors[_TOKENIZER] = torch.frombuffer(bytearray(weights.tokenizer.dump()), dtype=torch.uint8)
    header = {
        "format": FORMAT,
        "vocabulary": weights.network.vocabulary,
        "tokenizer": weights.tokenizer.name,
        "eyes": weights.eyes,
        "about": dict(weights.about),
    }
    write_tensors(path, tensors, header)


def read_weights(path: Path) -> Weights:
    """Return the weights of a file, in evaluation mode.

    Raises:
        BadWeights: if the file is not readable.
    """
    tensors, header = read_tensors(path)
    if header.get("format") != FORMAT:
        raise BadWeights(f"{path} has the format {header.get('format')!r}, expected {FORMAT!r}")
    try:
        tokenizer = restore_tokenizer(header["tokenizer"], tensors.pop(_TOKENIZER).numpy().tobytes())
        network = Grounded(header["vocabulary"])
        network.load_state_dict({name: value.float() for name, value in tensors.items()})
    except (KeyError, TypeError, RuntimeError) as error:
        raise BadWeights(f"{path} does not hold the weights of a {Grounded.__name__}: {error}") from error
    network.requires_grad_(requires_grad=False)
    return Weights(network.eval(), tokenizer, header["eyes"], header["about"])
