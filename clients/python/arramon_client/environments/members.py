"""One episode of a vector environment as `call`, `get_attr` and `set_attr` of Gymnasium know it."""

from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt

from arramon_client.agent import Label
from arramon_client.environments.backend import Player
from arramon_client.environments.episodes import Episodes
from arramon_client.environments.labels import FactoredLabels, factored
from arramon_client.environments.pictures import Picture
from arramon_client.environments.spaces import NO_ACTION, action_space
from arramon_client.environments.tokens import Tokenizer
from arramon_client.world import NAVIGATION, PHASES


class Member:
    """An episode of a vector environment: attributes of `ArraMonEnv`, and those that a program sets.

    Args:
        episodes: of the environment.
        max_episode_steps: of the vector environment.
        render_mode: of the vector environment.

    Attributes:
        tokenizer: of the instructions.
        render_mode: "rgb_array" or None.
    """

    def __init__(self, episodes: Episodes, max_episode_steps: int | None, render_mode: str | None) -> None:
        opened = episodes.opened
        self._episodes, self._limit = episodes, max_episode_steps
        self._translator, self._picture = opened.translator(), Picture()
        self.tokenizer: Tokenizer = opened.tokenizer
        self.render_mode = render_mode
        self.action_space = action_space()
        self.observation_space = opened.observation_space()

    @property
    def player(self) -> Player:
        """What plays the episodes."""
        return self._episodes.player

    @property
    def task(self) -> str:
        """What the agent does now: "navigation" or "assembly"; empty before the first episode."""
        return self._episodes.task

    @property
    def task_description(self) -> str:
        """The present instruction; empty before the first episode."""
        return self._episodes.task_description

    @property
    def episode_id(self) -> str:
        """Id of the present episode; empty before the first."""
        return self.player.episode_id if self._episodes.begun else ""

    @property
    def labels(self) -> tuple[Label, ...]:
        """Meaning of a segmentation's values, by index; empty without that sensor."""
        return self.player.labels

    @property
    def factored_labels(self) -> FactoredLabels:
        """The same as arrays."""
        return factored(self.labels)

    @property
    def _max_episode_steps(self) -> int:
        """The most actions that an episode takes, under the name of Gymnasium's wrapper, by which LeRobot reads it."""
        if self._limit is not None:
            return self._limit
        settings = self._episodes.opened.settings
        first = 2 * (settings.turn - 1) + (settings.start != NAVIGATION)
        played = sum(PHASES[phase % 2] in settings.phases for phase in range(first, 4))
        return played * self.player.split.steps_per_phase

    def render(self) -> npt.NDArray[np.uint8] | None:
        """Return a picture of the episode, (height, width, 3) uint8; None unless the mode is "rgb_array".

        Raises:
            gymnasium.error.ResetNeeded: if none has begun.
        """
        if self.render_mode != "rgb_array":
            return None
        if not self._episodes.begun:
            raise gymnasium.error.ResetNeeded("no episode has begun; call reset() before render()")
        return self._picture.draw(self._translator.full_observation(self.player.latest(), NO_ACTION), self.player)

    def get_wrapper_attr(self, name: str) -> Any:
        """Return an attribute by its name."""
        return getattr(self, name)
