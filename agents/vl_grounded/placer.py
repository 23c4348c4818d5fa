"""One assembly phase: a look around, the cell that the network finds, and the shortest way to it."""

from collections import deque
from collections.abc import Sequence

import torch
from torch import Tensor

from agents.learning.eyes.names import NamedThing
from agents.shortest_path.room import COLUMNS, RoomPose, plan, quarter_of
from agents.vl_grounded.look import Look, as_named
from agents.vl_grounded.network import Grounded
from arramon_client.agent import Action
from lang.room import START

RESERVE = 26
"""Largest number of steps to any cell, including the placement: with no more left, looking around stops."""


class Placer:
    """Plays one assembly phase.

    Args:
        network: that finds the cell.
        tokens: the instruction, (1, T).
    """

    def __init__(self, network: Grounded, tokens: Tensor) -> None:
        self._network, self._tokens = network, tokens
        self._look = Look()
        self._way: deque[int] = deque()

    @property
    def looks(self) -> bool:
        """Whether the things in the present frame are wanted."""
        return not self._way and self._look.is_new

    def act(self, things: Sequence[NamedThing], steps_left: int) -> int:
        """Return the next action.

        Args:
            things: in the present frame; none if they are not wanted.
            steps_left: in the phase.
        """
        if self._way:
            return self._way.popleft()
        if self.looks:
            self._look.add(things)
        turn = self._look.turn() if steps_left > RESERVE + 1 else None
        if turn is not None:
            return turn
        quarter, first = quarter_of(self._look.heading)
        row, column = divmod(self._cell(), COLUMNS)
        self._way.extend([*first, *(plan(RoomPose(*START, quarter), (column, row), ()) or ()), Action.INTERACT])
        return self._way.popleft()

    @torch.inference_mode()
    def _cell(self) -> int:
        """Return the number of the best cell."""
        words = self._network.reading(self._tokens)
        there = as_named([self._look.things()])
        return int(self._network.room(self._network.reading, words, self._tokens, there)[0].argmax())
