"""Agent that never moves and takes INTERACT at every step: a lower bound for all agents.

If nothing is in reach, INTERACT does nothing, and the phase runs to its step limit.
"""

from collections.abc import Sequence

from arramon_client.agent import Action, Episode, Observation

__all__ = ["Agent"]


class Agent:
    """Agent that only interacts."""

    name = "stop"
    sensors = ("rgb", "depth")  # Unused, but transferred as for a real agent.

    def begin(self, episode: Episode) -> None:
        """Do nothing: there is no memory."""

    def act(self, observations: Sequence[Observation]) -> list[Action]:
        """Return INTERACT for each observation."""
        return [Action.INTERACT] * len(observations)
