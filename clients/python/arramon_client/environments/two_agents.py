"""The PettingZoo environments for `navigator` and `assembler`, who act alternately (AEC) or in parallel.

Importing this module registers them: `pettingzoo.make("aec", "arramon/ArraMon-v0")`, or "parallel". `env()`,
`raw_env()` and `parallel_env()` make them too.
"""

import copy
from typing import Any, Self

import numpy as np
import numpy.typing as npt
from gymnasium import spaces
from pettingzoo import AECEnv, ParallelEnv, aec_registry, register
from pettingzoo.utils.wrappers import OrderEnforcingWrapper

from arramon_client.environments.agents import AGENTS, TwoAgents
from arramon_client.environments.pictures import Picture, Window
from arramon_client.environments.single import RENDER_MODES, check_render_mode
from arramon_client.environments.spaces import Dict
from arramon_client.environments.tokens import Tokenizer

METADATA = {"name": "arramon_v0", "render_modes": list(RENDER_MODES), "render_fps": 10, "is_parallelizable": True}


class _EpisodeDisplay:
    """Renders an episode to an array or in a window, depending on the render mode."""

    def __init__(self, render_mode: str | None) -> None:
        check_render_mode(render_mode)
        self._mode, self._picture = render_mode, Picture()
        self._window: Window | None = None

    def show(self, episode: TwoAgents) -> npt.NDArray[np.uint8] | None:
        if self._mode is None:
            return None
        picture = self._picture.draw(episode.active_observation(), episode.player)
        if self._mode == "rgb_array":
            return picture
        self._window = self._window or Window("ArraMon", int(str(METADATA["render_fps"])))
        self._window.show(picture)
        return None

    def close(self) -> None:
        if self._window is not None:
            self._window.close()
            self._window = None


class _TwoAgentsBase:
    """Base of both environments, with the episode, its spaces and its rendering. It must be the first base class."""

    metadata = METADATA

    def __init__(self, render_mode: str | None = None, message_length: int = 0, **options: object) -> None:
        super().__init__()
        self._display = _EpisodeDisplay(render_mode)
        self._episode = TwoAgents(message_length, **options)
        self.render_mode = render_mode
        self.possible_agents = list(AGENTS)
        self.agents: list[str] = []
        self.observation_spaces = dict(self._episode.observation_spaces)
        self.action_spaces = dict(self._episode.action_spaces)

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name != "_display"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._display = _EpisodeDisplay(self.render_mode)

    def __copy__(self) -> Self:
        """Return a deep copy, with an episode of its own."""
        return copy.deepcopy(self)

    @property
    def tokenizer(self) -> Tokenizer:
        """The tokenizer of the instructions."""
        return self._episode.tokenizer

    @property
    def player(self) -> Any:
        """The player of the current episode, with its split, labels and hash chain."""
        return self._episode.player

    def observation_space(self, agent: str) -> spaces.Dict:
        """Return an agent's observation space, the same object each time."""
        return self._episode.observation_spaces[agent]

    def action_space(self, agent: str) -> "spaces.Space[Any]":
        """Return an agent's action space, the same object each time."""
        return self._episode.action_spaces[agent]

    def render(self) -> npt.NDArray[np.uint8] | None:
        """Return a picture with the active agent's view; None unless the mode is "rgb_array"."""
        return self._display.show(self._episode) if self.render_mode == "rgb_array" else None

    def close(self) -> None:
        """Release all resources. On a host, end the run."""
        self._display.close()
        self._episode.close()

    def _show(self) -> None:
        if self.render_mode == "human":
            self._display.show(self._episode)


class ArraMonAEC(_TwoAgentsBase, AECEnv[str, Dict, Any]):  # type: ignore[misc]  # PettingZoo is not typed
    """The benchmark for two agents that act alternately; `env()` adds PettingZoo's wrapper that checks the call order.

    The navigator acts in the city, the assembler in the room. Each gets its own observations, and the rewards of its
    own phases.

    Args:
        render_mode: None, "rgb_array" or "human".
        message_length: number of symbols that an agent sends to the other with each action; 0 for no messages.
        options: the fields of `arramon_client.environments.options.Options`, except `phases`.

    Raises:
        BadArgument, NoBackend: as for `ArraMonEnv`.
    """

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> None:
        """Begin an episode; seed and options as for `ArraMonEnv.reset`.

        Raises:
            BadArgument: if there is no episode of a given id.
        """
        info = self._episode.begin(seed, options)
        self.agents = list(AGENTS)
        self.rewards = dict.fromkeys(AGENTS, 0.0)
        self._cumulative_rewards = dict.fromkeys(AGENTS, 0.0)
        self.terminations = dict.fromkeys(AGENTS, False)
        self.truncations = dict.fromkeys(AGENTS, False)
        self.infos: dict[str, dict[str, Any]] = {agent: dict(info) for agent in AGENTS}
        self.agent_selection = self._episode.active
        self._show()

    def observe(self, agent: str) -> Dict:
        """Return an agent's latest observation in a phase of its own; a blank one before its first phase."""
        return self._episode.observation(agent)

    def step(self, action: Any) -> None:
        """Apply the action of the selected agent; None for an agent whose episode has ended.

        Raises:
            gymnasium.error.InvalidAction: if the action is not 0 to 3.
        """
        agent = self.agent_selection
        if self.terminations[agent]:
            self._was_dead_step(action)
            return
        self._clear_rewards()
        self._cumulative_rewards[agent] = 0.0
        reward, info = self._episode.step(action)
        self.rewards[agent] = reward
        self.infos = {each: {} for each in AGENTS}
        self.infos[agent] = info
        if self._episode.is_over:
            self.terminations = dict.fromkeys(AGENTS, True)
            self.infos = {each: dict(info) for each in AGENTS}
        self.agent_selection = self._episode.active
        self._accumulate_rewards()
        self._deads_step_first()
        self._show()


class ArraMonParallel(_TwoAgentsBase, ParallelEnv[str, Dict, Any]):  # type: ignore[misc]
    """The benchmark for two agents that act at once, for libraries that require it.

    The action of the inactive agent is ignored, and its observation stays as it was, with `active` 0.

    Args:
        render_mode, message_length, options: as for `ArraMonAEC`.

    Raises:
        BadArgument, NoBackend: as for `ArraMonEnv`.
    """

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Dict], dict[str, dict[str, Any]]]:
        """Begin an episode; seed and options as for `ArraMonEnv.reset`. Return observations and infos by agent.

        Raises:
            BadArgument: if there is no episode of a given id.
        """
        info = self._episode.begin(seed, options)
        self.agents = list(AGENTS)
        self._show()
        return self._observations(), {agent: dict(info) for agent in AGENTS}

    def step(
        self, actions: dict[str, Any]
    ) -> tuple[dict[str, Dict], dict[str, float], dict[str, bool], dict[str, bool], dict[str, dict[str, Any]]]:
        """Apply the action of the active agent.

        Returns:
            Observations, rewards, terminated, truncated (always False) and infos, by agent.

        Raises:
            gymnasium.error.InvalidAction: if the action is not 0 to 3.
            gymnasium.error.ResetNeeded: if the episode has ended.
            KeyError: if there is no action for the active agent.
        """
        acting = self._episode.active
        reward, info = self._episode.step(None if self._episode.is_over else actions[acting])
        over = self._episode.is_over
        rewards = {agent: reward if agent == acting else 0.0 for agent in AGENTS}
        infos = {agent: dict(info) if over or agent == acting else {} for agent in AGENTS}
        if over:
            self.agents = []
        self._show()
        return self._observations(), rewards, dict.fromkeys(AGENTS, over), dict.fromkeys(AGENTS, False), infos

    def _observations(self) -> dict[str, Dict]:
        return {agent: self._episode.observation(agent) for agent in AGENTS}


def raw_env(**arguments: Any) -> ArraMonAEC:
    """Return the AEC environment without wrappers."""
    return ArraMonAEC(**arguments)


def env(**arguments: Any) -> "OrderEnforcingWrapper[str, Dict, Any]":
    """Return the AEC environment in PettingZoo's wrapper that checks the order of calls."""
    return OrderEnforcingWrapper(ArraMonAEC(**arguments))


def parallel_env(**arguments: Any) -> ArraMonParallel:
    """Return the parallel environment."""
    return ArraMonParallel(**arguments)


if "arramon/ArraMon-v0" not in aec_registry:
    register("aec", "arramon/ArraMon-v0", entry_point=f"{__name__}:env")
    register("parallel", "arramon/ArraMon-v0", entry_point=f"{__name__}:parallel_env")
