"""What an agent that keeps a map perceives in an observation: labels of pixels, and named things."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple

from arramon_client.agent import Observation

if TYPE_CHECKING:
    from arramon_agents.perception.eyes.names import NamedThing  # It needs PyTorch.


class Percept(NamedTuple):
    """An observation as perceived.

    Attributes:
        observation: its segmentation is the run's, or what a visual encoder made of RGB and depth.
        things: that a visual encoder named; none with the run's segmentation.
    """

    observation: Observation
    things: Sequence["NamedThing"] = ()


Perceive = Callable[[Sequence[Observation]], Sequence[Percept]]
"""Returns what is perceived in each observation, of different episodes."""


def perceive_as_given(observations: Sequence[Observation]) -> list[Percept]:
    """Return observations with the run's own segmentation."""
    return [Percept(observation) for observation in observations]
