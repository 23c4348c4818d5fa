"""An agent plugin: arramon-client --agent examples.my_agent --split val_seen --lang en

It walks where the view is deepest, and picks up or places at random moments.
"""

import random
from collections.abc import Sequence

import numpy as np

from arramon_client import Action, Episode, Observation


class Agent:
    """An agent that sees depth alone, and keeps one random generator for each episode."""

    sensors = ("depth",)

    def __init__(self) -> None:
        self._chance: dict[str, random.Random] = {}

    def begin(self, episode: Episode) -> None:
        """Begin an episode; seeded by its id, so that a run can be resumed."""
        self._chance[episode.episode_id] = random.Random(episode.episode_id)  # noqa: S311

    def end(self, episode_id: str) -> None:
        """Discard what is kept of an episode; this method is optional."""
        del self._chance[episode_id]

    def act(self, observations: Sequence[Observation]) -> list[Action]:
        """Return one action for each observation."""
        return [self._choose(observation) for observation in observations]

    def _choose(self, seen: Observation) -> Action:
        assert seen.depth is not None
        if self._chance[seen.episode_id].random() < 0.05:
            return Action.INTERACT
        left, ahead, right = (float(np.median(part)) for part in np.array_split(seen.depth, 3, axis=1))
        if ahead >= max(left, right, 1.5):
            return Action.FORWARD
        return Action.LEFT if left > right else Action.RIGHT
