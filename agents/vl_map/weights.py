"""Files of the policy's weights: safetensors in half precision, with sizes and what else is known in the header."""

from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import torch

from agents.learning.checkpoint import BadWeights, read_tensors, write_tensors
from agents.vl_map.network import PolicyNetwork, Sizes

FORMAT = "vl_map 1"


def write_policy(path: Path, network: PolicyNetwork, about: Mapping[str, Any]) -> None:
    """Write a policy's network to a file, which appears complete or not at all.

    Args:
        path: the file.
        network: trained.
        about: what else is known of it, as JSON values.
    """
    tensors = {name: value.detach().to(torch.float16).contiguous() for name, value in network.state_dict().items()}
    write_tensors(path, tensors, {"format": FORMAT, "sizes": asdict(network.sizes), "about": dict(about)})


def read_policy(path: Path) -> tuple[PolicyNetwork, dict[str, Any]]:
    """Return the network of a file, ready for use, and what else is known of it.

    Raises:
        BadWeights: if it is no such file.
    """
    tensors, header = read_tensors(path)
    if header.get("format") != FORMAT:
        raise BadWeights(f"{path} has the format {header.get('format')!r}, expected {FORMAT!r}")
    try:
        network = PolicyNetwork(Sizes(**header["sizes"]))
        network.load_state_dict({name: value.float() for name, value in tensors.items()})
    except (KeyError, TypeError, RuntimeError) as error:
        raise BadWeights(f"{path} does not hold the weights of a {PolicyNetwork.__name__}: {error}") from error
    network.requires_grad_(requires_grad=False)
    return network.eval(), header["about"]
