"""The Gymnasium environment: one agent, one episode at a time."""

from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt
from gymnasium import spaces

from arramon_client.agent import Label
from arramon_client.environments.arguments import check_names, check_seed
from arramon_client.environments.conversion import keep_texts_in_wrappers
from arramon_client.environments.episodes import Episodes
from arramon_client.environments.errors import BadArgument
from arramon_client.environments.labels import FactoredLabels, factored
from arramon_client.environments.options import Options, make_options
from arramon_client.environments.pictures import Picture, Window
from arramon_client.environments.players import open_players
from arramon_client.environments.registration import PlainSpec
from arramon_client.environments.snapshots import Copyable
from arramon_client.environments.spaces import NO_ACTION, Dict, action_space
from arramon_client.world import ASSEMBLY

RENDER_MODES = ("human", "rgb_array")

ROOM_SPLIT, DRAWN_ROOM_SPLIT = "rooms", "drawn_rooms"
"""Splits of tasks in the assembly room alone: stored in a data folder, and drawn at random while playing."""


OWN_ARGUMENTS = ("render_mode",)
"""Arguments that are not in `Options`."""

NOT_IN_ROOM = ("split", "server", "phases", "start", "access")
"""Options that an environment of the assembly room alone does not have."""


class ArraMonEnv(Copyable, PlainSpec, gymnasium.Env[Dict, np.int64]):
    """The benchmark as a Gymnasium environment; `gymnasium.make("arramon/ArraMon-v0")` makes one.

    An episode has two turns of two phases each. `terminated` is set at its end. Reaching the step limit of a phase
    starts the next phase, so `truncated` is never set. The final observation repeats the one before.

    An environment in this process can be pickled and copied at any time: the copy is rebuilt from the arguments and the
    actions so far, and returns the same observations, rewards and scores for the same further actions.

    Args:
        render_mode: None, "rgb_array" or "human".
        options: the fields of `arramon_client.environments.options.Options`.

    Raises:
        BadArgument: if an argument is wrong; the message states what was expected.
        NoBackend: if no host is named, and the server package is not installed.
    """

    REBUILT = ("_episodes", "_translator", "_picture", "_window")
    metadata: dict[str, Any] = {  # noqa: RUF012 - as Gymnasium declares it
        "render_modes": list(RENDER_MODES),
        "render_fps": 10,
    }

    def __init__(self, render_mode: str | None = None, **options: object) -> None:
        check_render_mode(render_mode)
        opened = open_players(make_options(OWN_ARGUMENTS, **options))
        self.render_mode = render_mode
        self.action_space: spaces.Discrete = action_space()
        self.observation_space = opened.observation_space()
        self._last_action: int | None = None
        self._set_episodes(Episodes(opened))

    def _set_episodes(self, episodes: Episodes) -> None:
        """Set the attributes that a copy rebuilds instead of copying."""
        self._episodes = episodes
        self._translator = episodes.opened.translator()
        self._picture = Picture()
        self._window: Window | None = None

    @property
    def labels(self) -> tuple[Label, ...]:
        """Label of each segmentation value, by index; empty without that sensor."""
        return self.player.labels

    @property
    def factored_labels(self) -> FactoredLabels:
        """The labels as arrays: kind, colour and look of each label, as numbers."""
        return factored(self.labels)

    @property
    def task(self) -> str:
        """The current phase, "navigation" or "assembly"; empty before the first episode."""
        return self._episodes.task

    @property
    def task_description(self) -> str:
        """The current instruction; empty before the first episode."""
        return self._episodes.task_description

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Dict, dict[str, Any]]:
        """Begin an episode.

        Args:
            seed: seed of the generator that draws the episodes; on a host episodes come in the run's order instead.
            options: `{"episode": ID}` selects the episode; `{"lang": LANGUAGE}` its language, if there are several.

        Raises:
            BadArgument: if there is no such episode.
        """
        super().reset(seed=check_seed(seed))
        keep_texts_in_wrappers()
        seen, info = self._episodes.begin(self.np_random, options)
        self._last_action = NO_ACTION
        self._show()
        return self._translator.observation(seen, NO_ACTION), info

    def step(self, action: np.int64 | int) -> tuple[Dict, float, bool, bool, dict[str, Any]]:
        """Apply an action, 0 to 3, and return observation, reward, terminated, False and info.

        Raises:
            gymnasium.error.ResetNeeded: if the episode has ended, or none has begun.
            gymnasium.error.InvalidAction: if the action is not 0 to 3.
        """
        step, info = self._episodes.step(action)
        seen = self.player.latest() if step.observation is None else step.observation
        self._last_action = int(action)
        self._show()
        return self._translator.observation(seen, int(action)), step.reward, step.ending is not None, False, info

    def render(self) -> npt.NDArray[np.uint8] | None:
        """Return a picture of view, map and instruction, (height, width, 3) uint8; None unless the mode is "rgb_array".

        Raises:
            gymnasium.error.ResetNeeded: if no episode has begun.
        """
        if self.render_mode != "rgb_array":
            return None
        return self._render_picture()

    def close(self) -> None:
        """Release all resources. On a host, end the run."""
        if self._window is not None:
            self._window.close()
            self._window = None
        self._episodes.close()

    def _show(self) -> None:
        if self.render_mode == "human":
            self._window = self._window or Window("ArraMon", self.metadata["render_fps"])
            self._window.show(self._render_picture())

    def _render_picture(self) -> npt.NDArray[np.uint8]:
        if self._last_action is None:
            raise gymnasium.error.ResetNeeded("no episode has begun; call reset() before render()")
        return self._picture.draw(
            self._translator.full_observation(self.player.latest(), self._last_action), self.player
        )


def make_room(render_mode: str | None = None, **options: object) -> ArraMonEnv:
    """Return the environment of tasks in the assembly room alone; see `docs/reference/environments.md`.

    The tasks are drawn at random without end or, with `data`, taken from the split `rooms` in that data folder.

    Raises:
        BadArgument, NoBackend: as for `ArraMonEnv`.
    """
    return ArraMonEnv(render_mode, **room_options(options))


def room_options(options: dict[str, object], own: Sequence[str] = OWN_ARGUMENTS) -> dict[str, object]:
    """Return the options of an environment of the assembly room alone.

    Args:
        options: the options as given.
        own: names of the environment's further arguments, for error messages.

    Raises:
        BadArgument: for an option that such an environment does not have.
    """
    for name in NOT_IN_ROOM:
        if options.get(name) is not None:
            raise BadArgument(f"{name} is {options[name]!r}, but tasks in the room alone have no such argument")
    inherited = (name for name in Options.__dataclass_fields__ if name not in NOT_IN_ROOM)
    check_names((name for name in options if name not in NOT_IN_ROOM), (*inherited, *own))
    return {**options, "split": DRAWN_ROOM_SPLIT if options.get("data") is None else ROOM_SPLIT, "phases": (ASSEMBLY,)}


def check_render_mode(render_mode: str | None) -> None:
    """Raise BadArgument if the render mode is unknown."""
    if render_mode not in (None, *RENDER_MODES):
        raise BadArgument(f"render_mode is {render_mode!r}, expected None, {' or '.join(map(repr, RENDER_MODES))}")
