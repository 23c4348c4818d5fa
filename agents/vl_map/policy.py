"""The trained policy of an agent: the value of each option for an input."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
import torch

from arramon_agents.mapping.landmark_beliefs import Belief
from arramon_agents.vl_map.features import DIRECTIONS, Sample, mirror
from arramon_agents.vl_map.network import PolicyNetwork, batch_of
from arramon_agents.vl_map.options import WAYPOINTS

_MIRRORED = -np.arange(DIRECTIONS) % DIRECTIONS


class Policy:
    """Values options by a network, from a sample and from its mirror image.

    Args:
        network: trained, in evaluation mode.
        mirrored: whether the mirror image is used.
    """

    def __init__(self, network: PolicyNetwork, *, mirrored: bool = True) -> None:
        self._network, self._mirrored = network, mirrored

    @torch.inference_mode()
    def choose(self, sample: Sample, beliefs: Sequence[Belief]) -> npt.NDArray[np.float32]:  # noqa: ARG002
        """Return the values of all options, (OPTIONS,): log-probabilities, the mean of both."""
        if not self._mirrored:
            alone: npt.NDArray[np.float32] = self._network(batch_of([sample])).log_softmax(1)[0].numpy()
            return alone
        own, other = self._network(batch_of([sample, mirror(sample)])).log_softmax(1)
        waypoints = other[:WAYPOINTS].reshape(DIRECTIONS, -1)[_MIRRORED].flatten()
        values: npt.NDArray[np.float32] = ((own + torch.cat([waypoints, other[WAYPOINTS:]])) / 2.0).numpy()
        return values
