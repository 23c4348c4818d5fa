"""Trained policy of `vl_map`: log probabilities of the options; saving and loading the agent's networks."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import torch

from arramon_agents.mapping.probabilistic_landmark_memory import LandmarkBelief
from arramon_agents.vl_map.ensemble import PolicyEnsemble
from arramon_agents.vl_map.features import DIRECTIONS, PolicyInput, mirror
from arramon_agents.vl_map.network import PolicyNetwork, PolicySizes, batch_of
from arramon_agents.vl_map.options import WAYPOINTS
from arramon_agents.vl_map.placement_network import PlacementNetwork
from arramon_agents.weights import read_weights_file, write_weights_file

FORMAT = "vl_map 2"

PLACER = "placer."
"""Prefix of the placement network's tensor names."""

MAX_POLICIES = 16
"""Maximum number of policies in a file."""

_MIRRORED = -np.arange(DIRECTIONS) % DIRECTIONS


class MapPolicy:
    """Policy that averages networks over an input and its mirror image.

    Args:
        networks: trained networks, in evaluation mode; at least one. Their parameters are copied.
        mirrored: whether to use the mirror image too.
    """

    def __init__(self, networks: Sequence[PolicyNetwork], *, mirrored: bool = True) -> None:
        by_sizes: dict[PolicySizes, list[PolicyNetwork]] = {}
        for network in networks:
            by_sizes.setdefault(network.sizes, []).append(network)
        self._ensembles = [PolicyEnsemble(alike) for alike in by_sizes.values()]
        self._mirrored = mirrored

    @torch.inference_mode()
    def option_values(self, sample: PolicyInput, beliefs: Sequence[LandmarkBelief]) -> npt.NDArray[np.float32]:  # noqa: ARG002
        """Return the log probabilities of all options, (OPTIONS,), averaged over networks and mirror images."""
        batch = batch_of([sample, mirror(sample)] if self._mirrored else [sample])
        found = torch.cat([ensemble(batch) for ensemble in self._ensembles]).log_softmax(2).mean(0)
        own = found[0]
        if self._mirrored:
            waypoints = found[1, :WAYPOINTS].reshape(DIRECTIONS, -1)[_MIRRORED].flatten()
            own = (own + torch.cat([waypoints, found[1, WAYPOINTS:]])) / 2.0
        values: npt.NDArray[np.float32] = own.numpy()
        return values


class Networks(NamedTuple):
    """The agent's own trained networks.

    Attributes:
        policies: choose options while navigating, by their average; at least one.
        placer: predicts the target cell of the room.
    """

    policies: Sequence[PolicyNetwork]
    placer: PlacementNetwork


def write_policy(path: Path, networks: Networks, about: Mapping[str, Any]) -> None:
    """Write the networks to a file, atomically; `about` is metadata, as JSON values."""
    policies = networks.policies
    header = {
        "format": FORMAT,
        "policies": len(policies),
        "about": dict(about),
        **{_sizes(number): asdict(policy.sizes) for number, policy in enumerate(policies)},
    }
    prefixed = {_prefix(number): policy for number, policy in enumerate(policies)}
    write_weights_file(path, {**prefixed, PLACER: networks.placer}, header)


def read_policy(path: Path) -> tuple[Networks, dict[str, Any]]:
    """Return the networks of a file, in evaluation mode, and their metadata.

    Raises:
        BadWeights: if the file cannot be read.
    """
    file = read_weights_file(path, "agents.vl_map", FORMAT)
    count = file.value("policies", int) if "policies" in file.header else 1
    if not 1 <= count <= MAX_POLICIES:
        raise file.wrong(f"its header has {count} policies, expected 1 to {MAX_POLICIES}")
    names = [_sizes(number) for number in range(count)]  # Older files have the sizes of the first policy alone.
    sizes = [file.sizes(name if name in file.header else "sizes", PolicySizes) for name in names]
    policies = [file.build(partial(PolicyNetwork, each)) for each in sizes]
    placer = PlacementNetwork()
    prefixed = {_prefix(number): policy for number, policy in enumerate(policies)}
    for prefix, network in {**prefixed, PLACER: placer}.items():
        file.fill(network, prefix)
        network.requires_grad_(requires_grad=False)
    return Networks(policies, placer), file.value("about", dict)


def _sizes(number: int) -> str:
    """Return the name of a policy's sizes in the header."""
    return f"sizes{number + 1}" if number else "sizes"


def _prefix(number: int) -> str:
    """Return the prefix of a policy's tensor names: files of a single policy have no numbers."""
    return f"policy{number + 1}." if number else "policy."
