"""Player of one assembly phase: look around, predict the target cell by the network, take the shortest path to it."""

from collections import deque

import torch
from torch import Tensor

from arramon_agents.mapping.room_path import RoomPose, plan, quarter_and_turns
from arramon_agents.vl_grounded.look_around import LookAround, attributes_in_rooms
from arramon_agents.vl_grounded.network import Grounded
from arramon_client.agent import Action
from arramon_client.world import COLUMNS
from arramon_lang.cell_grading import START

RESERVED_STEPS = 26
"""Steps reserved for walking to any cell and placing the object; with no more left, the agent stops looking around."""


class AssemblyPlayer:
    """Plays one assembly phase.

    Args:
        network: predicts the target cell.
        tokens: token ids of the instruction, (1, T).
        look: the initial look around.
    """

    def __init__(self, network: Grounded, tokens: Tensor, look: LookAround) -> None:
        self._network, self._tokens = network, tokens
        self.look = look
        self._plan: deque[int] = deque()

    def is_looking(self) -> bool:
        """Return whether the current frame is a new view of the look around; True once for each heading."""
        return not self._plan and self.look.is_new()

    def act(self, steps_left: int) -> int:
        """Return the next action, given the number of steps left in the phase."""
        if self._plan:
            return self._plan.popleft()
        turn = self.look.turn() if steps_left > RESERVED_STEPS + 1 else None
        if turn is not None:
            return turn
        quarter, first = quarter_and_turns(self.look.heading)
        row, column = divmod(self._cell(), COLUMNS)
        self._plan.extend([*first, *(plan(RoomPose(*START, quarter), (column, row), ()) or ()), Action.INTERACT])
        return self._plan.popleft()

    @torch.inference_mode()
    def _cell(self) -> int:
        """Return the index of the cell with the highest logit."""
        words = self._network.reading(self._tokens)
        seen = attributes_in_rooms([self.look.things()])
        return int(self._network.room(self._network.reading, words, self._tokens, seen)[0].argmax())
