"""The sequence of episodes behind every kind of environment: choice of the next episode, steps and infos."""

from collections.abc import Mapping, Sequence
from typing import Any

import gymnasium
import numpy as np

from arramon_client.agent import Action, Observation
from arramon_client.environments.arguments import check_choice, is_whole_number
from arramon_client.environments.backend import Player, Step
from arramon_client.environments.errors import BadArgument
from arramon_client.environments.players import PlayerSet
from arramon_client.errors import UsageError

ACTIONS = len(Action)

DRAWN_SEEDS = 2**31 - 1
"""Upper bound of the seeds of randomly drawn tasks, exclusive."""


class Episodes:
    """The episodes of one environment, one after another.

    Args:
        opened: the players and their settings.

    Attributes:
        opened: the players and their settings.
        player: the player of the current episode.
        is_over: whether the current episode has ended, or none has begun.
        closed: whether the environment was closed.
        begun: language, id (None for a randomly drawn task or the run's next episode) and seed of the current episode;
            None before the first.
        actions: actions of the current episode, in order.
        advised: the expert's action in each state of the current episode, in order; empty without an expert.
    """

    def __init__(self, opened: PlayerSet) -> None:
        self.opened = opened
        self.player: Player = opened.player
        self.is_over = True
        self.closed = False
        self.begun: tuple[str, str | None, int] | None = None
        self.actions: list[int] = []
        self.advised: list[int] = []
        self._settings, self._tokenizer = opened.settings, opened.tokenizer.name

    @property
    def task(self) -> str:
        """The current phase, "navigation" or "assembly"; empty before the first episode."""
        return self.player.latest_without_images().phase if self.begun else ""

    @property
    def task_description(self) -> str:
        """The current instruction; empty before the first episode."""
        return self.player.latest_without_images().instruction if self.begun else ""

    def begin(
        self, random: np.random.Generator, options: Mapping[str, Any] | None, *, with_images: bool = True
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode, and return its first observation and its info.

        Args:
            random: generator that draws the episode, and its language if there are several.
            options: `{"episode": ID}` selects the episode, `{"lang": LANGUAGE}` the language. Other keys are ignored,
                as Gymnasium passes its own.
            with_images: whether to render the images of the observation.

        Raises:
            BadArgument: if there is no such episode.
        """
        language, named, seed = self._draw(random, options or {})
        try:
            seen = self.open(language, named, seed, with_images=with_images)
        except UsageError as error:
            raise BadArgument(str(error)) from error
        info = {
            "episode_id": seen.episode_id,
            "split": self._settings.split,
            "language": language,
            "tokenizer": self._tokenizer,
        }
        return seen, self._advised(info)

    def open(self, language: str, named: str | None, seed: int, *, with_images: bool = True) -> Observation:
        """Begin the episode with a language, id and seed, as in `begun`, and return its first observation.

        Raises:
            UsageError: if there is no such episode.
        """
        self._check_open("reset")
        self.player = self.opened.players[language]
        seen = self.player.begin(named, seed, with_images=with_images)
        self.is_over, self.begun, self.actions, self.advised = False, (language, named, seed), [], []
        return seen

    def _draw(self, random: np.random.Generator, options: Mapping[str, Any]) -> tuple[str, str | None, int]:
        """Return language, id and seed of the next episode."""
        players = self.opened.players
        if (wanted := options.get("lang")) is not None:
            check_choice("options['lang']", wanted, tuple(players))
            players = {wanted: players[wanted]}
        named = options.get("episode")
        if named is not None:
            named = str(named)
            languages = list(players)
            if len(players) > 1:
                has = {name: player.split.episode_ids for name, player in players.items()}
                languages = [name for name, ids in has.items() if ids is None or named in ids] or languages
            return _draw_language(random, languages), named, 0
        ids = {name: player.split.episode_ids for name, player in players.items()}
        counts = [len(some) for some in ids.values() if some is not None]
        if not counts:  # Randomly drawn tasks, or the next episode of a host's run.
            return _draw_language(random, list(players)), None, int(random.integers(DRAWN_SEEDS))
        number = int(random.integers(sum(counts)))
        for name, some in ids.items():
            if some is not None and number < len(some):
                return name, some[number], 0
            number -= len(some or ())
        raise AssertionError("the numbers add up")

    def step(self, action: Any) -> tuple[Step, dict[str, Any]]:
        """Apply an action, and return its result with an observation, and its info.

        Raises:
            gymnasium.error.ClosedEnvironmentError: if the environment was closed.
            gymnasium.error.ResetNeeded: if the episode has ended, or none has begun.
            gymnasium.error.InvalidAction: if the action is not 0 to 3.
        """
        self._check_begun()
        number = check_action(action)
        step = self.player.step(number)
        self.actions.append(number)
        return self._with_info(step)

    def advance(self, action: int) -> tuple[Step, dict[str, Any]]:
        """Apply an action from 0 to 3, and return its result without an observation, and its info.

        Raises:
            gymnasium.error.ClosedEnvironmentError: if the environment was closed.
            gymnasium.error.ResetNeeded: if the episode has ended, or none has begun.
        """
        self._check_begun()
        step = self.player.advance(action)
        self.actions.append(action)
        return self._with_info(step)

    def close(self) -> None:
        """Close all players."""
        self.is_over = self.closed = True
        for player in self.opened.players.values():
            player.close()

    def _check_open(self, method: str) -> None:
        if self.closed:
            raise gymnasium.error.ClosedEnvironmentError(
                f"{method}() was called after close(); make another environment"
            )

    def _check_begun(self) -> None:
        self._check_open("step")
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
            self.advised.append(info["expert_action"])
        return info


def _draw_language(random: np.random.Generator, languages: Sequence[str]) -> str:
    """Draw one of the languages; without using a random number if there is only one, as releases with one did."""
    return languages[0] if len(languages) == 1 else languages[int(random.integers(len(languages)))]


def check_action(action: Any) -> int:
    """Return an action as an int.

    Raises:
        gymnasium.error.InvalidAction: if it is not 0 to 3.
    """
    if type(action) is int and 0 <= action < ACTIONS:
        return action
    if isinstance(action, np.ndarray) and action.shape == ():
        action = action[()]
    if is_whole_number(action) and 0 <= action < ACTIONS:
        return int(action)
    raise gymnasium.error.InvalidAction(
        f"the action is {action!r}, expected 0 (forward), 1 (left), 2 (right) or 3 (interact)"
    )
