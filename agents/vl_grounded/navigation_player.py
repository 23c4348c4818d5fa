"""Player of one navigation phase: the network's best action, with rules for pick-ups, blocked steps and turning."""

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor

from arramon_agents.perception.encoder import GRID
from arramon_agents.perception.eyes.grid import CHANNEL_NAMES
from arramon_agents.vl.model import ACTIONS, START_ACTION, as_input
from arramon_agents.vl_grounded.instruction_encoder import best_match
from arramon_agents.vl_grounded.network import Grounded
from arramon_agents.vl_grounded.odometry import odometry
from arramon_client.agent import Action

MIN_MATCH = 0.4
"""Minimum match with the target object for a pick-up, as a share of the best possible match."""

NEAR = 1.0 / (1.0 + 3.6)
"""Minimum nearness for a pick-up: a little beyond the reach."""

_NEARNESS = CHANNEL_NAMES.index("nearness of collectible")
_MIDDLE = [cell for cell in range(GRID * GRID) if 2 <= cell % GRID <= 4]
"""Indices of the image cells straight ahead."""

_OPPOSITE = {Action.LEFT: Action.RIGHT, Action.RIGHT: Action.LEFT}


MAX_TURNS_IN_A_ROW = 6
"""Maximum number of consecutive turns in one direction, half a circle: the expert never makes more."""


class NavigationPlayer:
    """Plays one navigation phase.

    After an action without effect (a blocked step, an empty pick-up) the network chooses again from the same recurrent
    state, without that action. Between two steps the agent turns in one direction only, and at most half a circle
    unless its last step was blocked.

    Args:
        network: predicts action logits.
        tokens: token ids of the instruction, (1, T).

    Attributes:
        state: the recurrent state.
    """

    def __init__(self, network: Grounded, tokens: Tensor) -> None:
        self._network, self._tokens = network, tokens
        self._words = network.reading(tokens)
        self._target = network.street.read_target(self._words, tokens)
        self._best = best_match(network.reading.probabilities(self._target[:, None])).item()
        self.state = self._next_state = network.street.initial_state(tokens)
        self._actions: list[int] = []
        self._ineffective: set[int] = set()
        self._is_at_wall = False
        self._last: npt.NDArray[np.float32] | None = None

    @torch.inference_mode()
    def act(self, features: npt.NDArray[np.uint8], depth: npt.NDArray[np.float32]) -> int:
        """Return the next action.

        Args:
            features: visual features of the current frame, (7, 7, C).
            depth: depth image of the frame.
        """
        self._check_last_action(depth)
        previous = self._actions[-1] if self._actions else START_ACTION
        street = self._network.street
        (inputs,) = street.step_inputs(
            self._network.reading,
            self._target,
            as_input(features)[None, None],
            torch.tensor([[previous]]),
            torch.from_numpy(odometry(self._actions)[None, -1:]),
        )
        output, self._next_state = street.step(self._network.reading, self._words, self._tokens, inputs, self.state)
        logits = street.output(output)[0]
        excluded = self._ineffective | self._excluded_turns()
        if not is_in_reach(inputs.target_match[0] / self._best, features):
            excluded.add(Action.INTERACT)
        action = max((each for each in range(ACTIONS) if each not in excluded), key=lambda each: float(logits[each]))
        self._actions.append(action)
        self._last = depth.copy()
        return action

    def _check_last_action(self, depth: npt.NDArray[np.float32]) -> None:
        """Advance the recurrent state if the last action had an effect; otherwise exclude the action."""
        if self._last is None:
            return
        action = self._actions[-1]
        if action not in _OPPOSITE and np.array_equal(depth, self._last):
            self._actions.pop()
            self._ineffective.add(action)
            self._is_at_wall |= action == Action.FORWARD
            return
        self.state = self._next_state
        self._ineffective.clear()
        if action == Action.FORWARD:
            self._is_at_wall = False

    def _excluded_turns(self) -> set[int]:
        """Return the turns that the rules exclude, given the turns since the last step."""
        if not self._actions or self._actions[-1] not in _OPPOSITE:
            return set()
        turn = Action(self._actions[-1])
        is_enough = self._actions[-MAX_TURNS_IN_A_ROW:] == [turn] * MAX_TURNS_IN_A_ROW and not self._is_at_wall
        return {_OPPOSITE[turn], turn} if is_enough else {_OPPOSITE[turn]}


def is_in_reach(matches: Tensor, features: npt.NDArray[np.uint8]) -> bool:
    """Return whether something that matches the target object is straight ahead and near.

    Args:
        matches: match of each cell with the target, (N,), as a share of the best possible match.
        features: visual features of the frame, (7, 7, C).
    """
    near = features.reshape(GRID * GRID, -1)[_MIDDLE, _NEARNESS] >= NEAR * 255
    return bool(((matches[_MIDDLE] >= MIN_MATCH).numpy() & near).any())
