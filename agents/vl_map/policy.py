"""The trained policy of an agent: the value of each option for an input."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
import torch

from agents.learning.memory.landmarks import Belief
from agents.vl_map.features import Sample
from agents.vl_map.network import PolicyNetwork, batch_of


class Policy:
    """Values options by a network.

    Args:
        network: trained, in evaluation mode.
    """

    def __init__(self, network: PolicyNetwork) -> None:
        self._network = network

    @torch.inference_mode()
    def choose(self, sample: Sample, beliefs: Sequence[Belief]) -> npt.NDArray[np.float32]:  # noqa: ARG002
        """Return the values of all options, (OPTIONS,)."""
        values: npt.NDArray[np.float32] = self._network(batch_of([sample]))[0].numpy()
        return values
