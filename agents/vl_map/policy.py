"""Trained policy of `vl_map`: log probabilities of the options; saving and loading the agent's networks."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import torch

from arramon_agents.mapping.probabilistic_landmark_memory import LandmarkBelief
from arramon_agents.vl_map.features import DIRECTIONS, PolicyInput, mirror
from arramon_agents.vl_map.network import PolicyNetwork, PolicySizes, batch_of
from arramon_agents.vl_map.options import WAYPOINTS
from arramon_agents.vl_map.placement_network import PlacementNetwork
from arramon_agents.weights import read_weights_file, write_weights_file

FORMAT = "vl_map 2"

_MIRRORED = -np.arange(DIRECTIONS) % DIRECTIONS


class MapPolicy:
    """Policy that averages a network over an input and its mirror image.

    Args:
        network: trained network, in evaluation mode.
        mirrored: whether to use the mirror image too.
    """

    def __init__(self, network: PolicyNetwork, *, mirrored: bool = True) -> None:
        self._network, self._mirrored = network, mirrored

    @torch.inference_mode()
    def option_values(self, sample: PolicyInput, beliefs: Sequence[LandmarkBelief]) -> npt.NDArray[np.float32]:  # noqa: ARG002
        """Return the log probabilities of all options, (OPTIONS,), averaged over the input and its mirror image."""
        if not self._mirrored:
            alone: npt.NDArray[np.float32] = self._network(batch_of([sample])).log_softmax(1)[0].numpy()
            return alone
        own, other = self._network(batch_of([sample, mirror(sample)])).log_softmax(1)
        waypoints = other[:WAYPOINTS].reshape(DIRECTIONS, -1)[_MIRRORED].flatten()
        values: npt.NDArray[np.float32] = ((own + torch.cat([waypoints, other[WAYPOINTS:]])) / 2.0).numpy()
        return values


class Networks(NamedTuple):
    """The agent's own trained networks; field names are prefixes of tensor names.

    Attributes:
        policy: chooses options while navigating.
        placer: predicts the target cell of the room.
    """

    policy: PolicyNetwork
    placer: PlacementNetwork


def write_policy(path: Path, networks: Networks, about: Mapping[str, Any]) -> None:
    """Write the networks to a file, atomically; `about` is metadata, as JSON values."""
    header = {"format": FORMAT, "sizes": asdict(networks.policy.sizes), "about": dict(about)}
    write_weights_file(path, {f"{name}.": network for name, network in networks._asdict().items()}, header)


def read_policy(path: Path) -> tuple[Networks, dict[str, Any]]:
    """Return the networks of a file, in evaluation mode, and their metadata.

    Raises:
        BadWeights: if the file cannot be read.
    """
    file = read_weights_file(path, "agents.vl_map", FORMAT)
    sizes = file.sizes("sizes", PolicySizes)
    networks = Networks(file.build(lambda: PolicyNetwork(sizes)), PlacementNetwork())
    for name, network in networks._asdict().items():
        file.fill(network, f"{name}.")
        network.requires_grad_(requires_grad=False)
    return networks, file.value("about", dict)
