"""Weight files of the policy: safetensors in half precision, with sizes and metadata in the header."""

from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any, NamedTuple

import torch

from arramon_agents.vl_map.network import PolicyNetwork, Sizes
from arramon_agents.vl_map.room import Placer
from arramon_agents.weights import BadWeights, read_tensors, write_tensors

FORMAT = "vl_map 2"


class Networks(NamedTuple):
    """The agent's own trained networks.

    Attributes:
        policy: chooses waypoints in the street.
        placer: finds the target cell of the room.
    """

    policy: PolicyNetwork
    placer: Placer


def write_policy(path: Path, networks: Networks, about: Mapping[str, Any]) -> None:
    """Write the networks to a file, atomically.

    Args:
        path: the file.
        networks: the trained networks.
        about: metadata, as JSON values.
    """
    tensors = {
        f"{part}.{name}": value.detach().to(torch.float16).contiguous()
        for part, network in networks._asdict().items()
        for name, value in network.state_dict().items()
    }
    write_tensors(path, tensors, {"format": FORMAT, "sizes": asdict(networks.policy.sizes), "about": dict(about)})


def read_policy(path: Path) -> tuple[Networks, dict[str, Any]]:
    """Return the networks of a file, in evaluation mode, and their metadata.

    Raises:
        BadWeights: if the file is not readable.
    """
    tensors, header = read_tensors(path)
    if header.get("format") != FORMAT:
        raise BadWeights(f"{path} has the format {header.get('format')!r}, expected {FORMAT!r}")
    try:
        networks = Networks(PolicyNetwork(Sizes(**header["sizes"])), Placer())
        for part, network in networks._asdict().items():
            own = {
                name.removeprefix(f"{part}."): value.float() for name, value in tensors.items() if name.startswith(part)
            }
            network.load_state_dict(own)
            network.eval().requires_grad_(requires_grad=False)
    except (KeyError, TypeError, RuntimeError) as error:
        raise BadWeights(f"{path} does not hold the weights of a {PolicyNetwork.__name__}: {error}") from error
    return networks, header["about"]
