"""Weight files of the encoder: safetensors in half precision, with the network's sizes in the metadata."""

import json
from dataclasses import asdict, fields
from pathlib import Path

import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import save_file
from torch import nn

from arramon.strict_json import NotJsonError, read_json
from arramon_agents.perception.eyes.naming import NamingNetwork
from arramon_agents.perception.eyes.network import EyesNetwork, Sizes, folded

LARGEST = 1 << 16
"""Maximum of a size in a file: a network of any size would be allocated before its tensors are found to be missing."""

BLOCKS, NAMING = "blocks.", "naming."
"""Prefix of the tensor names of each network."""


def write_weights(path: Path, blocks: EyesNetwork, naming: NamingNetwork) -> None:
    """Write the weights of both networks, with the first one's sizes under the key "sizes" of the metadata."""
    tensors = {
        prefix + name: value.to(torch.float16).contiguous() if value.is_floating_point() else value
        for prefix, network in ((BLOCKS, blocks), (NAMING, naming))
        for name, value in network.state_dict().items()
    }
    save_file(tensors, path, {"sizes": json.dumps(asdict(blocks.sizes))})


def read_weights(path: Path) -> tuple[EyesNetwork, NamingNetwork]:
    """Return both networks, in evaluation mode.

    Raises:
        FileNotFoundError: if there is no such file.
        ValueError: if it does not hold networks of this kind.
    """
    if not path.is_file():
        command = "python -m arramon_agents.learning.train_eyes"
        raise FileNotFoundError(f"there are no weights at {path}; train them: {command}")
    try:
        with safe_open(path, "pt") as file:
            about = file.metadata() or {}
            if "sizes" not in about:
                raise ValueError(f"{path} holds no weights of the visual encoder: its metadata has no 'sizes'")
            blocks, naming = EyesNetwork(_sizes(about["sizes"])), NamingNetwork()
            tensors = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118 - not a mapping
    except (SafetensorError, NotJsonError) as error:
        raise ValueError(f"{path} holds no weights of the visual encoder: {error}") from error
    for prefix, network in ((BLOCKS, blocks), (NAMING, naming)):
        _fill(network, {name.removeprefix(prefix): value for name, value in tensors.items() if name.startswith(prefix)})
    return blocks, naming


def _sizes(text: str) -> Sizes:
    content = read_json(text)
    names = [field.name for field in fields(Sizes)]
    if not isinstance(content, dict) or not content.keys() <= set(names):
        raise NotJsonError(f"has 'sizes' that are no object with {', '.join(names)}")
    for name, size in content.items():
        if type(size) is not int or not 1 <= size <= LARGEST:
            raise NotJsonError(f"has the size {name} {size!r}, expected a whole number from 1 to {LARGEST}")
    return Sizes(**content)


def _fill(network: nn.Module, tensors: dict[str, torch.Tensor]) -> None:
    network.load_state_dict(
        {name: value.float() if value.is_floating_point() else value for name, value in tensors.items()}
    )
    network.requires_grad_(requires_grad=False)
    network.eval()
    folded(network)
    network.to(memory_format=torch.channels_last)  # type: ignore[call-overload]
