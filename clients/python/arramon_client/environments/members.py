"""The attributes of one episode that Gymnasium's `call`, `get_attr` and `set_attr` of a vector environment reach."""

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
    """One member of a vector environment, with the attributes of `ArraMonEnv` and those that a program sets.

    Args:
        episodes: the member's episodes.
        max_episode_steps: the vector environment's limit of actions; None for no limit.
        render_mode: the vector environment's render mode.

    Attributes:
        tokenizer: tokenizer of the instructions.
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
        """The player of the current episode."""
        return self._episodes.player

    @property
    def task(self) -> str:
        """The current phase, "navigation" or "assembly"; empty before the first episode."""
        return self._episodes.task

    @property
    def task_description(self) -> str:
        """The current instruction; empty before the first episode."""
        return self._episodes.task_description

    @property
    def episode_id(self) -> str:
        """Id of the current episode; empty before the first."""
        return self.player.episode_id if self._episodes.begun else ""

    @property
    def labels(self) -> tuple[Label, ...]:
        """Label of each segmentation value, by index; empty without that sensor."""
        return self.player.labels

    @property
    def factored_labels(self) -> FactoredLabels:
        """The labels as arrays."""
        return factored(self.labels)

    @property
    def _max_episode_steps(self) -> int:
        """Maximum number of actions in an episode, under the name in Gymnasium's wrapper, which LeRobot reads."""
        if self._limit is not None:
            return self._limit
        settings = self._episodes.opened.settings
        first = 2 * (settings.turn - 1) + (settings.start != NAVIGATION)
        played = sum(PHASES[phase % 2] in settings.phases for phase in range(first, 4))
        return played * self.player.split.steps_per_phase

    def render(self) -> npt.NDArray[np.uint8] | None:
        """Return a picture of the episode, (height, width, 3) uint8; None unless the mode is "rgb_array".

        Raises:
            gymnasium.error.ResetNeeded: if no episode has begun.
        """
        if self.render_mode != "rgb_array":
            return None
        if not self._episodes.begun:
            raise gymnasium.error.ResetNeeded("no episode has begun; call reset() before render()")
        return self._picture.draw(self._translator.full_observation(self.player.latest(), NO_ACTION), self.player)

    def get_wrapper_attr(self, name: str) -> Any:
        """Return the attribute with this name."""
        return getattr(self, name)
