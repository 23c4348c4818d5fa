"""Look around the assembly room from its start tile: the turns to make, and the objects seen."""

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
import numpy.typing as npt
import torch

from arramon_agents.mapping.room_memory import RoomMemory
from arramon_agents.perception.eyes.vocabulary import COLOURS
from arramon_agents.vl_grounded.attributes import KINDS, LOOKS, Attributes
from arramon_agents.vl_grounded.placement_network import CELLS, LEVELS
from arramon_client.agent import Action
from arramon_client.world import COLLECTIBLES, COLUMNS, TURN_DEGREES
from arramon_lang.cell_grading import RoomObject

TURNS = (*[Action.LEFT] * 3, *[Action.RIGHT] * 6)
"""Turns that show the whole room, without the wall behind the start tile."""


class LookAround:
    """One look around the room.

    Args:
        room: accumulates what is seen.

    Attributes:
        heading: in degrees clockwise from the first one.
    """

    def __init__(self, room: RoomMemory) -> None:
        self.room = room
        self.heading = 0
        self._turns = list(TURNS)
        self._headings: set[int] = set()

    def is_new(self) -> bool:
        """Return whether the current heading is new, and mark it as seen."""
        is_new = self.heading not in self._headings
        self._headings.add(self.heading)
        return is_new

    def turn(self) -> Action | None:
        """Return the next turn, and mark it as made; None at the end."""
        if not self._turns:
            return None
        action = self._turns.pop(0)
        self.heading += TURN_DEGREES if action == Action.RIGHT else -TURN_DEGREES
        return action

    def things(self) -> tuple[RoomObject, ...]:
        """Return the objects seen so far."""
        return self.room.room().things


def attributes_in_rooms(rooms: Sequence[Sequence[RoomObject]]) -> Attributes:
    """Return the objects in rooms as a batch of attributes, (B, CELLS LEVELS, ...): cells row by row, with levels."""
    parts = [
        np.zeros((len(rooms), CELLS * LEVELS, size), np.float32) for size in (len(KINDS), len(COLOURS), len(LOOKS))
    ]
    for number, things in enumerate(rooms):
        for thing in things:
            place = (thing.row * COLUMNS + thing.column) * LEVELS + min(thing.level, LEVELS) - 1
            for part, row in zip(parts, _rows(thing.kind, thing.colour, thing.look), strict=True):
                part[number, place] = row
    return Attributes(*map(torch.from_numpy, parts))


@lru_cache
def _rows(kind: str, colour: str, look: str) -> tuple[npt.NDArray[np.float32], ...]:
    """Return one-hot kinds, colours and looks of a collectible."""
    kinds, colours, looks = (np.zeros(size, np.float32) for size in (len(KINDS), len(COLOURS), len(LOOKS)))
    kinds[[KINDS.index("collectible"), KINDS.index(kind, 1, 1 + len(COLLECTIBLES))]] = 1.0
    colours[COLOURS.index(colour)] = 1.0
    looks[LOOKS.index(("pattern", look))] = 1.0
    return kinds, colours, looks
