"""One episode after another as Gymnasium has them: what the single environment, the vector and the two agents share."""

from collections.abc import Mapping
from typing import Any

import gymnasium
import numpy as np

from arramon_client.agent import Action, Observation
from arramon_client.environments.backend import Images, Player, Step
from arramon_client.environments.errors import BadArgument
from arramon_client.environments.options import Opened
from arramon_client.errors import UsageError

ACTIONS = len(Action)

DRAWN_SEEDS = 2**31 - 1
"""Seeds of drawn tasks are less than this."""


class Episodes:
    """Episodes of one player: which comes next, and what is told about each.

    Args:
        opened: what is played with.

    Attributes:
        player: plays the episodes.
        is_over: whether there is no episode that takes actions.
    """

    def __init__(self, opened: Opened) -> None:
        self.player: Player = opened.player
        self.is_over = True
        self._ids = self.player.split.episode_ids
        self._settings, self._tokenizer = opened.settings, opened.tokenizer.name

    def begin(
        self, random: np.random.Generator, options: Mapping[str, Any] | None, into: Images | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode, and return its first observation and its info.

        Args:
            random: draws the episode.
            options: `{"episode": ID}` names it instead. Other keys are ignored, as Gymnasium's own are passed on.
            into: arrays to write the images to.

        Raises:
            BadArgument: if there is no such episode.
        """
        named = (options or {}).get("episode")
        seed = 0
        if named is None and self._ids is not None:
            named = self._ids[int(random.integers(len(self._ids)))]
        elif named is None:
            seed = int(random.integers(DRAWN_SEEDS))
        try:
            seen = self.player.begin(None if named is None else str(named), seed, into)
        except UsageError as error:
            raise BadArgument(str(error)) from error
        self.is_over = False
        info = {
            "episode_id": seen.episode_id,
            "split": self._settings.split,
            "language": self._settings.language,
            "tokenizer": self._tokenizer,
        }
        return seen, self._advised(info)

    def step(self, action: Any) -> tuple[Step, dict[str, Any]]:
        """Apply an action, and return what it led to, with an observation, and its info.

        Raises:
            gymnasium.error.ResetNeeded: if the episode has ended, or none has begun.
            gymnasium.error.InvalidAction: if the action is none of the four.
        """
        self._check_begun()
        return self._with_info(self.player.step(checked(action)))

    def advance(self, action: int) -> tuple[Step, dict[str, Any]]:
        """Apply an action from 0 to 3, and return what it led to, without an observation, and its info.

        Raises:
            gymnasium.error.ResetNeeded: if the episode has ended, or none has begun.
        """
        self._check_begun()
        return self._with_info(self.player.advance(action))

    def _check_begun(self) -> None:
        if self.is_over:
            raise gymnasium.error.ResetNeeded("the episode has ended; call reset() before step()")

    def _with_info(self, step: Step) -> tuple[Step, dict[str, Any]]:
        info: dict[str, Any] = {}
        if step.phases_ended:
            turn, phase = step.phases_ended[-1]
            info["phase_ended"] = f"turn {turn}, {phase}"
        if step.ending is None:
            return step, self._advised(info)
        self.is_over = True
        info["cause"] = step.ending.cause
        if step.ending.scores is not None:
            info["scores"] = {name: dict(scores) for name, scores in step.ending.scores.items()}
        return step, info

    def _advised(self, info: dict[str, Any]) -> dict[str, Any]:
        if self._settings.expert is not None:
            info["expert_action"] = self.player.expert_action()
        return info


def checked(action: Any) -> int:
    """Return an action as a number.

    Raises:
        gymnasium.error.InvalidAction: if it is none of the four.
    """
    if type(action) is int and 0 <= action < ACTIONS:
        return action
    if isinstance(action, int | np.integer) or (isinstance(action, np.ndarray) and action.shape == ()):
        number = int(action)
        if 0 <= number < ACTIONS and not isinstance(action, bool):
            return number
    raise gymnasium.error.InvalidAction(
        f"the action is {action!r}, expected 0 (forward), 1 (left), 2 (right) or 3 (interact)"
    )
