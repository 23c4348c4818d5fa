"""Follows an assembly instruction: looks round the room, finds the cell that is meant, walks up to it and places."""

from collections import deque
from collections.abc import Sequence

from agents.follower.room_sight import RoomSight
from agents.shortest_path.room import Stand, plan, quarter_of
from arramon_client.agent import Action, Label, Observation
from lang.meaning import Assembly
from lang.placing import START, Cell, find_cell, is_all_there, quarter_after

TURN = 30
"""Degrees of one turn."""

LOOKS = 11
"""Frames that show everything around, one turn apart, with a field of view of two turns."""

RESERVE = 26
"""Steps that the way to any cell takes at most, the placement included: with no more left it looks no further."""

OUTLOOK: Cell = (2, 3)
"""Facing this cell from the one before it, the agent looks round again if it misses something named."""


class RoomFollower:
    """Plays one assembly phase by depth and segmentation alone.

    Args:
        meaning: of the phase's instruction; a part of it that fits nothing in the room is passed over.
        labels: `Episode.labels`.

    Raises:
        ValueError: if there are no labels.
    """

    def __init__(self, meaning: Assembly, labels: Sequence[Label]) -> None:
        self._meaning = meaning
        self._sight = RoomSight(labels)
        self._cell: Cell = START
        self._heading = 0
        self._ahead: deque[Action] = deque()
        self._looks_left = LOOKS
        self._has_outlook = False
        self._aside = Action.LEFT if quarter_after(meaning.turns) == 3 else Action.RIGHT

    def act(self, observation: Observation) -> int:
        """The next action; the observations are to be those of one assembly phase from its beginning.

        Raises:
            ValueError: if the observation has no depth or no segmentation.
        """
        if observation.depth is None or observation.segmentation is None:
            raise ValueError("the observation has no depth or no segmentation; the room follower needs both sensors")
        if not self._ahead:
            if self._looks_left:
                self._sight.add(observation.depth, observation.segmentation, self._cell, self._heading)
                self._looks_left -= 1
            self._ahead.extend(self._next(observation.steps_left))
        action = self._ahead.popleft()
        self._moved(action)
        return action

    def _next(self, steps_left: int) -> list[Action]:
        """What to do now: look further, look from elsewhere, or place."""
        may_look = steps_left > RESERVE + 1
        if self._looks_left and may_look:
            return [self._aside]
        room = self._sight.room()
        if not self._has_outlook and steps_left > 2 * RESERVE and not is_all_there(self._meaning, room):
            self._has_outlook, self._looks_left = True, LOOKS
            return self._way(OUTLOOK) or [self._aside]
        self._looks_left = 0
        return [*self._way(find_cell(self._meaning, room)[0]), Action.INTERACT]

    def _way(self, target: Cell) -> list[Action]:
        """The actions to where the target cell is the one ahead."""
        quarter, first = quarter_of(self._heading)
        way = plan(Stand(*self._cell, quarter), target, ())
        if way is None:
            raise ValueError(f"{target} is not a cell of the room")
        return first + way

    def _moved(self, action: Action) -> None:
        """Keeps count of where it stands; it walks towards no wall."""
        if action is Action.FORWARD:
            column, row = Stand(*self._cell, self._heading // 90).ahead
            self._cell = column, row
        elif action is not Action.INTERACT:
            self._heading = (self._heading + (TURN if action is Action.RIGHT else -TURN)) % 360
