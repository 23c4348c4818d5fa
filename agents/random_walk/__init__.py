"""Acts by chance: the paper's random-walk baseline (table 2, R/W)."""

import hashlib
from collections.abc import Sequence

from arramon_client.agent import Action, Episode, Observation

__all__ = ["Agent"]


class Agent:
    """Each action is drawn uniformly, by a hash of the seed, the episode and the step; so it needs no memory.

    Args:
        seed: another one draws other actions.
    """

    name = "random_walk"
    sensors = ("rgb", "depth")  # It looks at neither, but travels with what a real agent travels with.

    def __init__(self, seed: int = 0) -> None:
        self._seed = seed

    def begin(self, episode: Episode) -> None:
        """Nothing is remembered."""

    def act(self, observations: Sequence[Observation]) -> list[Action]:
        """One action for each observation."""
        return [self.draw(observation.episode_id, observation.step) for observation in observations]

    def draw(self, episode_id: str, step: int) -> Action:
        """The action of an episode's step."""
        digest = hashlib.blake2b(f"{self._seed}/{step}/{episode_id}".encode(), digest_size=1).digest()
        return Action(digest[0] % len(Action))  # 256 is a multiple of 4: no action is favoured.
