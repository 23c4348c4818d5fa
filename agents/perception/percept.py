"""Result of perception for agents that keep a map: segmentation and detected things."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple

from arramon_client.agent import Observation

if TYPE_CHECKING:
    from arramon_agents.perception.eyes.detected_things import DetectedThing  # It needs PyTorch.


class Percept(NamedTuple):
    """A perceived observation.

    Attributes:
        observation: observation with the run's segmentation, or with one predicted by a visual encoder.
        things: things named by a visual encoder; empty with the run's segmentation.
    """

    observation: Observation
    things: Sequence["DetectedThing"] = ()


Perceive = Callable[[Sequence[Observation]], Sequence[Percept]]
"""Perceives a batch of observations of different episodes."""


def perceive_as_given(observations: Sequence[Observation]) -> list[Percept]:
    """Return observations with the run's own segmentation."""
    return [Percept(observation) for observation in observations]
