"""Policy of the paper's models: model, tokenizer and visual encoder; saving and loading it."""

from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import torch

from arramon_agents.perception.encoder import VisualEncoder
from arramon_agents.perception.registry import open_encoder
from arramon_agents.reading.tokenizers import TextTokenizer, restore_tokenizer
from arramon_agents.vl.config import ModelConfig
from arramon_agents.vl.model import Model
from arramon_agents.weights import BadWeights, read_weights_file, write_weights_file

FORMAT = 1


@dataclass
class VlPolicy:
    """A trained model with its tokenizer and visual encoder.

    Attributes:
        model: the network, in evaluation or training mode.
        tokenizer: tokenizer of instructions.
        encoder: visual encoder; None for a model that does not see.
        about: metadata as JSON values: data, seeds, scores.
    """

    model: Model
    tokenizer: TextTokenizer
    encoder: VisualEncoder | None
    about: dict[str, Any] = field(default_factory=dict)


def save_policy(policy: VlPolicy, path: Path) -> None:
    """Write a policy to a file, atomically."""
    header = {
        "format": FORMAT,
        "config": asdict(policy.model.config),
        "tokenizer": policy.tokenizer.name,
        "encoder": None if policy.encoder is None else [policy.encoder.name, policy.encoder.fingerprint],
        "about": policy.about,
    }
    networks, blobs = {"model.": policy.model}, {"tokenizer": policy.tokenizer.dump()}
    write_weights_file(path, networks, header, blobs, torch.float32)


def load_policy(path: Path) -> VlPolicy:
    """Load a policy from a file, in evaluation mode, on the CPU.

    Raises:
        BadWeights: if the file cannot be read, or was trained with another version of its visual encoder.
        ValueError: if its tokenizer or encoder is not available.
    """
    file = read_weights_file(path, "the paper's model", FORMAT)
    config = file.sizes("config", ModelConfig)
    model = file.build(lambda: Model(config))
    file.fill(model, "model.")
    tokenizer = restore_tokenizer(file.value("tokenizer", str), file.blob("tokenizer"))
    encoder = None
    if file.header.get("encoder") is not None:
        name, fingerprint = file.value("encoder", list)
        encoder = open_encoder(name)
        if encoder.fingerprint != fingerprint:
            raise BadWeights(
                f"{path} was trained on the visual encoder {name} {fingerprint}, but {encoder.fingerprint} is installed"
            )
    return VlPolicy(model, tokenizer, encoder, file.value("about", dict))
