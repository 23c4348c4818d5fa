"""Files of weights: safetensors with the configuration as JSON in their header, never pickle."""

import json
import os
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import safetensors
import torch
from safetensors.torch import save_file
from torch import Tensor

from arramon.strict_json import NotJsonError, read_json
from arramon_agents.perception.encoder import VisualEncoder
from arramon_agents.perception.registry import open_encoder
from arramon_agents.reading.tokenizers import Tokenizer, restore_tokenizer
from arramon_agents.vl.config import Config
from arramon_agents.vl.model import Model

SHIPPED = Path(__file__).parent
"""Folder of the agents; each one's folder holds its shipped weights and its model card."""

WEIGHTS, CARD = "weights.safetensors", "card.md"
"""Names of the shipped files in an agent's folder."""

FORMAT = 1
SUFFIX = ".safetensors"
_TOKENIZER = "tokenizer"


class BadWeights(ValueError):
    """A file of weights cannot be read, or does not fit this version."""


@dataclass
class Policy:
    """A trained model with its tokenizer and visual encoder.

    Attributes:
        model: in evaluation or training mode.
        tokenizer: of instructions.
        encoder: of images; None for a model that uses none.
        about: metadata: data, seeds, scores; JSON values.
    """

    model: Model
    tokenizer: Tokenizer
    encoder: VisualEncoder | None
    about: dict[str, Any] = field(default_factory=dict)


def find_weights(name: str) -> Path:
    """Return the path of shipped weights by their name, or of a file by its path.

    Raises:
        BadWeights: if there is neither.
    """
    shipped = SHIPPED / name / WEIGHTS
    for path in (shipped, Path(name)):
        if path.is_file():
            return path
    raise BadWeights(f"there are no weights {name!r}: neither a file {name} nor {shipped}")


def file_of(folder: Path, agent: str) -> Path:
    """Return the path of an agent's weights in a folder: that of all agents, or one that `arramon-train` wrote."""
    shipped = folder / agent / WEIGHTS
    return shipped if shipped.is_file() else folder / f"{agent}{SUFFIX}"


def find_initial(init: str, agent: str) -> Path:
    """Return the weights with which fine-tuning begins: a file, or of a folder the one named after the agent.

    Raises:
        BadWeights: if there are none.
    """
    given = Path(init)
    return find_weights(str(file_of(given, agent)) if given.is_dir() else init)


def save_policy(policy: Policy, path: Path) -> None:
    """Write a policy to a file, atomically."""
    tensors = {f"model.{name}": value.detach().cpu().contiguous() for name, value in policy.model.state_dict().items()}
    tensors[_TOKENIZER] = torch.frombuffer(bytearray(policy.tokenizer.dump()), dtype=torch.uint8)
    header = {
        "format": FORMAT,
        "config": asdict(policy.model.config),
        "tokenizer": policy.tokenizer.name,
        "encoder": None if policy.encoder is None else [policy.encoder.name, policy.encoder.fingerprint],
        "about": policy.about,
    }
    write_tensors(path, tensors, header)


def load_policy(path: Path) -> Policy:
    """Return the policy of a file, in evaluation mode, on the CPU.

    Raises:
        BadWeights: if the file is not readable, or was trained on another version of its visual encoder.
        ValueError: if its tokenizer or encoder is not available.
    """
    tensors, header = read_tensors(path)
    if header.get("format") != FORMAT or _TOKENIZER not in tensors:
        raise BadWeights(f"{path} has the format {header.get('format')!r}, expected {FORMAT}")
    try:
        config = Config(**header["config"])
        model = Model(config)
        model.load_state_dict({name[6:]: value for name, value in tensors.items() if name.startswith("model.")})
    except (KeyError, TypeError, RuntimeError) as error:
        raise BadWeights(f"{path} does not hold the weights of a {Model.__name__}: {error}") from error
    tokenizer = restore_tokenizer(header["tokenizer"], tensors[_TOKENIZER].numpy().tobytes())
    encoder = None
    if header["encoder"] is not None:
        name, fingerprint = header["encoder"]
        encoder = open_encoder(name)
        if encoder.fingerprint != fingerprint:
            raise BadWeights(
                f"{path} was trained on the visual encoder {name} {fingerprint}, but {encoder.fingerprint} is installed"
            )
    return Policy(model.eval(), tokenizer, encoder, header["about"])


def write_tensors(path: Path, tensors: Mapping[str, Tensor], header: Mapping[str, Any]) -> None:
    """Write tensors with a JSON header to a file, atomically."""
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f".{path.name}.{os.getpid()}")
    save_file(dict(tensors), part, {"arramon": json.dumps(header, ensure_ascii=False)})
    part.chmod(0o644)  # safetensors makes files for the owner alone.
    part.replace(path)


def read_tensors(path: Path) -> tuple[dict[str, Tensor], dict[str, Any]]:
    """Return tensors and JSON header of a file.

    Raises:
        BadWeights: if it cannot be read.
    """
    try:
        with safetensors.safe_open(path, framework="pt") as file:
            header = read_json((file.metadata() or {}).get("arramon", "{}"))
            return {name: file.get_tensor(name) for name in file.keys()}, header  # noqa: SIM118 - not a mapping
    except (OSError, safetensors.SafetensorError, NotJsonError) as error:
        raise BadWeights(f"{path} is no file of weights: {error}") from error


def as_input(features: np.ndarray[Any, np.dtype[np.uint8]]) -> Tensor:
    """Return quantised features as model input, float32 in [0, 1]."""
    return torch.from_numpy(features).float() / 255.0
