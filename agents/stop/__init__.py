"""Interacts at once and always: the floor that every agent should rise above.

Where nothing is in reach a pick-up does nothing, and the phase runs to its limit on the spot.
"""

from collections.abc import Sequence

from arramon_client.agent import Action, Episode, Observation

__all__ = ["Agent"]


class Agent:
    """Never moves."""

    name = "stop"
    sensors = ("rgb", "depth")  # It looks at neither, but travels with what a real agent travels with.

    def begin(self, episode: Episode) -> None:
        """Nothing is remembered."""

    def act(self, observations: Sequence[Observation]) -> list[Action]:
        """INTERACT for each observation."""
        return [Action.INTERACT] * len(observations)
