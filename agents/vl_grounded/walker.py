"""Player of one navigation phase: the network's actions, with rules for picking up and after blocked steps."""

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
"""Least match with the described object for a pick-up, as a share of the best possible match."""

NEAR = 1.0 / (1.0 + 3.6)
"""Least nearness for a pick-up: a little beyond its reach."""

_NEARNESS = CHANNEL_NAMES.index("nearness of collectible")
_MIDDLE = [cell for cell in range(GRID * GRID) if 2 <= cell % GRID <= 4]
"""Cells straight ahead."""

_OPPOSITE = {Action.LEFT: Action.RIGHT, Action.RIGHT: Action.LEFT}


MOST_TURNS = 6
"""Largest number of turns in a row, half a circle: the expert makes no more, and never turns back at once."""


class NavigationPlayer:
    """Plays one navigation phase.

    An action without effect, such as a blocked step or an empty pick-up, is taken back: the network chooses again, from
    the same state, among the others. Between two steps it turns in one direction alone, and no
    farther than half a circle, or after a blocked step until it can walk.

    Args:
        network: chooses actions.
        tokens: the instruction, (1, T).

    Attributes:
        mind: the recurrent state.
    """

    def __init__(self, network: Grounded, tokens: Tensor) -> None:
        self._network, self._tokens = network, tokens
        self._words = network.reading(tokens)
        self._target = network.street.read_target(self._words, tokens)
        self._best = best_match(network.reading.meant(self._target[:, None])).item()
        self.mind = self._after = network.street.first(tokens)
        self._actions: list[int] = []
        self._idle: set[int] = set()
        self._is_at_wall = False
        self._last: npt.NDArray[np.float32] | None = None

    @torch.inference_mode()
    def act(self, features: npt.NDArray[np.uint8], depth: npt.NDArray[np.float32]) -> int:
        """Return the next action.

        Args:
            features: of the current frame, (7, 7, C).
            depth: the frame's.
        """
        self._judge_last(depth)
        before = self._actions[-1] if self._actions else START_ACTION
        street = self._network.street
        (seen,) = street.see(
            self._network.reading,
            self._target,
            as_input(features)[None, None],
            torch.tensor([[before]]),
            torch.from_numpy(odometry(self._actions)[None, -1:]),
        )
        mixed, self._after = street.step(self._network.reading, self._words, self._tokens, seen, self.mind)
        values = street.output(mixed)[0]
        barred = self._idle | self._barred_turns()
        if not is_in_reach(seen.target[0] / self._best, features):
            barred.add(Action.INTERACT)
        action = max((each for each in range(ACTIONS) if each not in barred), key=lambda each: float(values[each]))
        self._actions.append(action)
        self._last = depth.copy()
        return action

    def _judge_last(self, depth: npt.NDArray[np.float32]) -> None:
        """Take back the last action if it had no effect, else advance the recurrent state."""
        if self._last is None:
            return
        action = self._actions[-1]
        if action not in _OPPOSITE and np.array_equal(depth, self._last):
            self._actions.pop()
            self._idle.add(action)
            self._is_at_wall |= action == Action.FORWARD
            return
        self.mind = self._after
        self._idle.clear()
        if action == Action.FORWARD:
            self._is_at_wall = False

    def _barred_turns(self) -> set[int]:
        """Return the turns that the rules forbid, given those since the last step."""
        if not self._actions or self._actions[-1] not in _OPPOSITE:
            return set()
        turn = Action(self._actions[-1])
        is_enough = self._actions[-MOST_TURNS:] == [turn] * MOST_TURNS and not self._is_at_wall
        return {_OPPOSITE[turn], turn} if is_enough else {_OPPOSITE[turn]}


def is_in_reach(fits: Tensor, features: npt.NDArray[np.uint8]) -> bool:
    """Return whether something that matches the described object is ahead and near.

    Args:
        fits: match of each cell, (N,), as a share of the best possible match.
        features: (7, 7, C).
    """
    near = features.reshape(GRID * GRID, -1)[_MIDDLE, _NEARNESS] >= NEAR * 255
    return bool(((fits[_MIDDLE] >= MIN_MATCH).numpy() & near).any())
