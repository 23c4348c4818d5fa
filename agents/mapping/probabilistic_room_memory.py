"""Memory of the assembly room with attribute probabilities, combined over all views of each cell."""

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from arramon_agents.mapping.probabilistic_landmark_memory import FULL_WEIGHT_PIXELS, MAX_WEIGHT, PROBABILITY_FLOOR
from arramon_agents.mapping.room_memory import RoomMemory
from arramon_agents.perception.eyes.detected_things import DetectedThing
from arramon_agents.perception.eyes.predicted_segmentation import label_of
from arramon_agents.perception.eyes.vocabulary import KINDS
from arramon_client.agent import Label
from arramon_client.world import CELL_SIZE, COLLECTIBLES, COLUMNS, ROWS
from arramon_lang.cell_grading import Cell, Room, RoomObject

OBJECT_RADIUS = 0.2
"""Distance from the visible side of an object to its centre, in units."""

MIN_STACKED_HEIGHT = 0.12
"""Minimum height of an object's lower end for it to be stacked on another, in units."""


class ProbabilisticRoomMemory(RoomMemory):
    """Accumulates frames of the room with detected things, and reconstructs its contents.

    Args:
        labels: labels of the segmentation, by index.
    """

    def __init__(self, labels: Sequence[Label]) -> None:
        super().__init__(labels)
        self._chances: dict[tuple[Cell, int], list[npt.NDArray[np.float64]]] = {}

    def add_things(self, things: Sequence[DetectedThing], cell: Cell, heading: float) -> None:
        """Add a frame's things.

        Args:
            things: with their names.
            cell: (column, row) of the camera.
            heading: of the camera, in degrees clockwise from +row.
        """
        sin, cos = math.sin(math.radians(heading)), math.cos(math.radians(heading))
        for named in things:
            if KINDS[int(named.kinds.argmax())] not in COLLECTIBLES:
                continue
            right, ahead = named.thing.right, named.thing.ahead + OBJECT_RADIUS
            column = round(cell[0] + (right * cos + ahead * sin) / CELL_SIZE)
            row = round(cell[1] + (ahead * cos - right * sin) / CELL_SIZE)
            if not (0 <= column < COLUMNS and 0 <= row < ROWS):
                continue
            # A thing whose lower end is hidden or cut off by the frame's edge may look raised: it needs one below.
            level = 2 if named.thing.low > MIN_STACKED_HEIGHT and ((column, row), 1) in self._chances else 1
            weight = min(MAX_WEIGHT, float(named.thing.mask.sum()) / FULL_WEIGHT_PIXELS)
            logs = [
                weight * np.log(part.astype(np.float64) + PROBABILITY_FLOOR)
                for part in (named.kinds, named.colours, named.looks)
            ]
            known = self._chances.setdefault(((column, row), level), [np.zeros_like(log) for log in logs])
            for total, log in zip(known, logs, strict=True):
                total += log

    def room(self) -> Room:
        """Return the room as seen so far."""
        things = []
        for (cell, level), chances in sorted(self._chances.items(), key=lambda item: item[0]):
            label = label_of(*chances)
            if label.kind in COLLECTIBLES:
                things.append(RoomObject(label.kind, label.colour, label.look, *cell, level))
        return Room(tuple(things), super().room().walls)
