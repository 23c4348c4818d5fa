"""One episode shared by two agents, `navigator` and `assembler`: the core of the PettingZoo environments."""

from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.utils import seeding

from arramon_client.agent import Observation
from arramon_client.environments.arguments import check_seed, whole_number
from arramon_client.environments.episodes import Episodes, check_action
from arramon_client.environments.errors import BadArgument
from arramon_client.environments.options import make_options
from arramon_client.environments.players import open_players
from arramon_client.environments.snapshots import Copyable
from arramon_client.environments.spaces import NO_ACTION, Dict, action_space
from arramon_client.world import ASSEMBLY, NAVIGATION, PHASES

NAVIGATOR, ASSEMBLER = "navigator", "assembler"
AGENTS = (NAVIGATOR, ASSEMBLER)
AGENT_OF = {NAVIGATION: NAVIGATOR, ASSEMBLY: ASSEMBLER}
"""The agent that acts in each phase."""

PHASE_OF = {agent: phase for phase, agent in AGENT_OF.items()}

OWN_ARGUMENTS = ("render_mode", "message_length")
"""Arguments that a single environment does not have."""

ACTIVE, MESSAGE = "active", "message"
"""Observation keys that a single environment does not have; MESSAGE only if `message_length` is above 0."""

MESSAGE_SYMBOLS = 32
"""Size of the alphabet of messages; symbol 0 means "no message"."""


class TwoAgents(Copyable):
    """An episode played alternately by two agents; shared by the AEC environment and the parallel one.

    Args:
        message_length: number of symbols that an agent sends to the other with each action; 0 for no messages.
        options: the fields of `arramon_client.environments.options.Options`.

    Raises:
        BadArgument: if an argument is wrong; the message states what was expected.
        NoBackend: if no host is named, and the server package is not installed.

    Attributes:
        action_spaces, observation_spaces: the spaces of each agent, by name.
        active: name of the agent that acts now; after the end of the episode, of the one that acted last.
        is_over: whether the episode has ended.
    """

    REBUILT = ("_episodes", "_translator")

    def __init__(self, message_length: int, **options: object) -> None:
        self._length = whole_number("message_length", message_length, "a number from 0", 0)
        if options.get("phases") is not None:
            raise BadArgument("phases cannot be given here: each phase is played by its own agent")
        more = (ACTIVE, MESSAGE) if self._length else (ACTIVE,)
        opened = open_players(make_options(OWN_ARGUMENTS, more, **options))
        observe = opened.options.observe
        self._more = tuple(key for key in more if observe is None or key in observe)
        self._set_episodes(Episodes(opened))
        self.action_spaces = {agent: self._action_space() for agent in AGENTS}
        self.observation_spaces = {agent: self._observation_space(opened.observation_space()) for agent in AGENTS}
        self._random: np.random.Generator | None = None
        self._seen: dict[str, Observation | None] = {}
        self._last_actions: dict[str, int] = {}
        self._messages: dict[str, Any] = {}
        self.active = NAVIGATOR
        self.is_over = True

    def _set_episodes(self, episodes: Episodes) -> None:
        """Set the attributes that a copy rebuilds instead of copying."""
        self._episodes = episodes
        self._translator = episodes.opened.translator()

    def begin(self, seed: int | None, options: dict[str, Any] | None) -> dict[str, Any]:
        """Begin an episode, and return its info.

        Raises:
            BadArgument: if `options` names an unknown episode or language.
        """
        if seed is not None or self._random is None:
            self._random, _ = seeding.np_random(check_seed(seed))
        seen, info = self._episodes.begin(self._random, options)
        self._seen = dict.fromkeys(AGENTS)
        self._last_actions = dict.fromkeys(AGENTS, NO_ACTION)
        self._messages = {agent: np.zeros(self._length, np.int64) for agent in AGENTS}
        self.is_over = False
        self._see(seen)
        return info

    def step(self, action: Any) -> tuple[float, dict[str, Any]]:
        """Apply the active agent's action, and return its reward and info.

        Args:
            action: 0 to 3; with messages `{"action": 0 to 3, "message": symbols}`.

        Raises:
            gymnasium.error.InvalidAction: if the action does not have that form.
            gymnasium.error.ResetNeeded: if the episode has ended.
        """
        agent = self.active
        other = ASSEMBLER if agent == NAVIGATOR else NAVIGATOR
        if self.is_over:
            raise gymnasium.error.ResetNeeded("the episode has ended; call reset() before step()")
        taken, message = self._split_action(action)
        step, info = self._episodes.step(taken)
        self._last_actions[agent] = taken
        self._messages[other] = message
        self.is_over = step.ending is not None
        if step.observation is not None:
            self._see(step.observation)
        return step.reward, info

    def observation(self, agent: str) -> Dict:
        """Return an agent's latest observation in a phase of its own; a blank one before its first phase.

        Raises:
            gymnasium.error.ResetNeeded: if no episode has begun.
        """
        values = self._translator.select_keys(self._full_observation(agent))
        # The same observation may be returned several times; each gets its own arrays.
        values = {name: value.copy() if isinstance(value, np.ndarray) else value for name, value in values.items()}
        if ACTIVE in self._more:
            values[ACTIVE] = np.int64(agent == self.active and not self.is_over)
        if MESSAGE in self._more:
            values[MESSAGE] = self._messages[agent].copy()
        return values

    def active_observation(self) -> Dict:
        """Return the active agent's observation with all keys, for rendering."""
        return self._full_observation(self.active)

    def close(self) -> None:
        """Close the player."""
        self._episodes.close()

    def _see(self, seen: Observation) -> None:
        self.active = AGENT_OF[seen.phase]
        self._seen[self.active] = seen

    def _action_space(self) -> "spaces.Space[Any]":
        if not self._length:
            return action_space()
        message = spaces.MultiDiscrete([MESSAGE_SYMBOLS] * self._length)
        return spaces.Dict({"action": action_space(), "message": message})

    def _observation_space(self, space: spaces.Dict) -> spaces.Dict:
        if ACTIVE in self._more:
            space[ACTIVE] = spaces.Discrete(2)
        text = space.spaces.get("instruction")
        if isinstance(text, spaces.Text):
            space["instruction"] = spaces.Text(text.max_length, min_length=0, charset=text.characters)
        if MESSAGE in self._more:
            space[MESSAGE] = spaces.MultiDiscrete([MESSAGE_SYMBOLS] * self._length)
        return space

    def _full_observation(self, agent: str) -> Dict:
        """Return an agent's observation with all keys of a single environment; a blank one before its first phase.

        Raises:
            gymnasium.error.ResetNeeded: if no episode has begun.
        """
        if not self._seen:
            raise gymnasium.error.ResetNeeded("no episode has begun; call reset() first")
        seen = self._seen[agent]
        if seen is not None:
            return self._translator.full_observation(seen, self._last_actions[agent])
        # A blank observation: no instruction, black images, no steps left.
        values: Dict = {}
        for name, space in self.observation_spaces[agent].items():
            if isinstance(space, spaces.Box):
                values[name] = np.zeros(space.shape, space.dtype)
        values["instruction"] = ""
        values["turn"] = np.int64(1)
        values["phase"] = np.int64(PHASES.index(PHASE_OF[agent]))
        values["last_action"] = np.int64(NO_ACTION)
        return values

    def _split_action(self, action: Any) -> tuple[int, Any]:
        """Return the checked action and message."""
        if not self._length:
            return check_action(action), np.zeros(0, np.int64)
        if not isinstance(action, dict) or action.keys() != {"action", "message"}:
            raise gymnasium.error.InvalidAction(
                f"the action is {action!r}, expected a dictionary of 'action' and 'message', as message_length is "
                f"{self._length}"
            )
        message = np.asarray(action["message"])
        is_right = message.shape == (self._length,) and message.dtype.kind in "iu"
        if not is_right or (message < 0).any() or (message >= MESSAGE_SYMBOLS).any():
            raise gymnasium.error.InvalidAction(
                f"the message is {action['message']!r}, expected {self._length} symbols from 0 to {MESSAGE_SYMBOLS - 1}"
            )
        return check_action(action["action"]), message.astype(np.int64)
