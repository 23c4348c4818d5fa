"""Agent that takes random actions: the paper's random-walk baseline (R/W in table 2)."""

import hashlib
from collections.abc import Sequence

from arramon_client.agent import Action, Episode, Observation

__all__ = ["Agent"]


class Agent:
    """Agent that draws actions uniformly, by a hash of seed, episode and step, so it has no state.

    Args:
        seed: different seeds give different actions.
    """

    name = "random_walk"
    sensors = ("rgb", "depth")  # Unused, but transferred as for a real agent.

    def __init__(self, seed: int = 0) -> None:
        self._seed = seed

    def begin(self, episode: Episode) -> None:
        """Do nothing: there is no memory."""

    def act(self, observations: Sequence[Observation]) -> list[Action]:
        """Return one action for each observation."""
        return [self.draw(observation.episode_id, observation.step) for observation in observations]

    def draw(self, episode_id: str, step: int) -> Action:
        """Return the action at an episode's step."""
        digest = hashlib.blake2b(f"{self._seed}/{step}/{episode_id}".encode(), digest_size=1).digest()
        return Action(digest[0] % len(Action))  # 256 is a multiple of 4, so the draw is uniform.
