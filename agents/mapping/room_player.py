"""Player of one assembly phase: look around the room, find the target cell, walk to it and place the object."""

from collections import deque
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from arramon_agents.mapping.notes import Intent
from arramon_agents.mapping.room_memory import RoomMemory
from arramon_agents.mapping.room_path import RoomPose, plan, quarter_and_turns
from arramon_client.agent import Action, Observation
from arramon_client.world import TURN_DEGREES
from arramon_lang.cell_grading import START, Cell, Room, find_cell, is_all_there, quarter_after
from arramon_lang.meaning import Assembly

if TYPE_CHECKING:
    from arramon_agents.perception.eyes.detected_things import DetectedThing  # It needs PyTorch.

LOOK_FRAMES = 11
"""Number of frames, one turn apart, that cover all directions with a field of view of two turns."""

RESERVED_STEPS = 26
"""Steps reserved for walking to any cell and placing the object; with no more left, the agent stops looking around."""

SECOND_LOOK_CELL: Cell = (2, 3)
"""Cell that the agent faces for a second look around if a named object was not found."""

FindCell = Callable[[Assembly, Room], Cell]
"""Returns the target cell, given the meaning of an instruction and the contents of the room."""


def find_by_rules(meaning: Assembly, room: Room) -> Cell:
    """Return the cell that matches an instruction best, by the rules of `arramon_lang.cell_grading`."""
    return find_cell(meaning, room)[0]


class RoomPlayer:
    """Plays one assembly phase by depth and segmentation, or by the detected things of the visual encoder.

    Args:
        meaning: meaning of the instruction; parts that match nothing in the room are ignored.
        memory: empty memory of the room.
        find: chooses the target cell; None for the rules of `arramon_lang.cell_grading`.
    """

    def __init__(self, meaning: Assembly, memory: RoomMemory, find: FindCell | None = None) -> None:
        self._meaning, self._find = meaning, find or find_by_rules
        self._memory = memory
        self._cell: Cell = START
        self._heading = 0
        self._ahead: deque[Action] = deque()
        self._looks_left = LOOK_FRAMES
        self._has_outlook = False
        self._goal: Cell | None = None
        self._turn_action = Action.LEFT if quarter_after(meaning.turns) == 3 else Action.RIGHT

    def act(self, observation: Observation, things: Sequence["DetectedThing"] = ()) -> int:
        """Return the next action; pass it the observations of one assembly phase, from the first one on.

        Raises:
            ValueError: if the observation has no depth or no segmentation.
        """
        if observation.depth is None or observation.segmentation is None:
            raise ValueError("the observation has no depth or no segmentation; the room follower requires both sensors")
        if not self._ahead:
            if self._looks_left:
                self._memory.add_things(things, self._cell, self._heading)
                self._memory.add(observation.depth, observation.segmentation, self._cell, self._heading)
                self._looks_left -= 1
            self._ahead.extend(self._next(observation.steps_left))
        action = self._ahead.popleft()
        self._moved(action)
        return action

    def intent(self) -> Intent:
        """Return the cell to put the object into, [column, row], as the goal; empty while it is not chosen."""
        return {"goal": list(self._goal)} if self._goal is not None else {}

    def _next(self, steps_left: int) -> list[Action]:
        """Return the next actions: look further, look from another cell, or place the object."""
        may_look = steps_left > RESERVED_STEPS + 1
        if self._looks_left and may_look:
            return [self._turn_action]
        room = self._memory.room()
        if not self._has_outlook and steps_left > 2 * RESERVED_STEPS and not is_all_there(self._meaning, room):
            self._has_outlook, self._looks_left = True, LOOK_FRAMES
            return self._path_to(SECOND_LOOK_CELL) or [self._turn_action]
        self._looks_left = 0
        self._goal = self._find(self._meaning, room)
        return [*self._path_to(self._goal), Action.INTERACT]

    def _path_to(self, target: Cell) -> list[Action]:
        """Return the actions to a pose whose cell ahead is the target."""
        quarter, first = quarter_and_turns(self._heading)
        path = plan(RoomPose(*self._cell, quarter), target, ())
        if path is None:
            raise ValueError(f"{target} is not a cell of the room")
        return first + path

    def _moved(self, action: Action) -> None:
        """Update the pose by an action; plans never walk into a wall."""
        if action is Action.FORWARD:
            column, row = RoomPose(*self._cell, self._heading // 90).ahead
            self._cell = column, row
        elif action is not Action.INTERACT:
            self._heading = (self._heading + (TURN_DEGREES if action is Action.RIGHT else -TURN_DEGREES)) % 360
