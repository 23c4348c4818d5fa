"""What stands where in the assembly room, by what depth and segmentation show from known cells."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from agents.follower.perceive import EYE_HEIGHT, FIELD_OF_VIEW
from arramon_client.agent import Label
from lang.placing import COLUMNS, ROWS, Cell, Room, Standing

CELL = 1.5
"""Side of a cell, in units."""

ENOUGH = 4
"""Pixels, over all frames, from which on something seen is there: fewer may be the edge of something else."""

FINE = 112
"""Pixels across that tell enough: of larger frames, not every row and column is looked at."""

_WALLS = np.array([ROWS - 0.5, COLUMNS - 0.5, 0.5, 0.5])
"""How far each quarter's wall is from the middle of cell (0, 0), in cells: towards +row, +column, -row, -column."""


_Floats = npt.NDArray[np.float64]


@dataclass(slots=True)
class _Trace:
    """What has been seen of one type of object in one cell: pixels, and the lowest height in units."""

    pixels: int
    lowest: float


class RoomSight:
    """Gathers frames of the room, and tells what is in it.

    Args:
        labels: `Episode.labels`, what the numbers of a segmentation mean.

    Raises:
        ValueError: if there are none, as without the sensor "segmentation".
    """

    def __init__(self, labels: Sequence[Label]) -> None:
        if not labels:
            raise ValueError('the episode has no labels; the room is seen with the sensor "segmentation"')
        self._labels = tuple(labels)
        self._is_object = np.array([_is_object(label) for label in labels])
        self._is_wall = np.array([label.kind == "wall" for label in labels])
        self._looks = int(self._is_wall.sum())
        self._traces: dict[tuple[int, Cell], _Trace] = {}
        self._walls: dict[str, int] = {}

    def add(
        self, depth: npt.NDArray[np.float32], segmentation: npt.NDArray[np.uint16], cell: Cell, heading: float
    ) -> None:
        """Takes in one frame.

        Args:
            depth: (size, size), units along the viewing direction, 0 where nothing was hit.
            segmentation: (size, size), each pixel's place in the labels.
            cell: (column, row) that it was seen from.
            heading: degrees clockwise from +row.
        """
        size = depth.shape[0]
        step = max(1, size // FINE)
        depth, shown = depth[::step, ::step], segmentation[::step, ::step].ravel()
        # Pixels apart for a unit aside at a unit's distance, and the first one's distance from the middle.
        scale = size / 2 / math.tan(math.radians(FIELD_OF_VIEW / 2)) / step, (0.5 - size / 2) / step
        pixels = np.flatnonzero(self._is_object[shown])
        column, row, height = _places(depth, pixels, scale, cell, heading)
        inside = (column > -0.5) & (column < COLUMNS - 0.5) & (row > -0.5) & (row < ROWS - 0.5)
        cells = np.rint(column).astype(int) * ROWS + np.rint(row).astype(int)
        keys = (shown[pixels].astype(int) * (COLUMNS * ROWS) + cells)[inside]
        found, which, counts = np.unique(keys, return_inverse=True, return_counts=True)
        lowest = np.full(len(found), np.inf)
        np.minimum.at(lowest, which, height[inside])
        for key, count, low in zip(found.tolist(), counts.tolist(), lowest.tolist(), strict=True):
            label, place = divmod(key, COLUMNS * ROWS)
            trace = self._traces.setdefault((label, divmod(place, ROWS)), _Trace(0, math.inf))
            trace.pixels += count
            trace.lowest = min(trace.lowest, low)
        if len(self._walls) < self._looks:
            every = np.flatnonzero(self._is_wall[shown])
            column, row, _ = _places(depth, every, scale, cell, heading)
            self._add_walls(shown[every], column, row)

    def room(self) -> Room:
        """What has been seen so far; objects that stand on one cell are on top of each other, by their heights."""
        things = []
        cells = sorted({cell for (_, cell), trace in self._traces.items() if trace.pixels >= ENOUGH})
        for cell in cells:
            seen = [(t.lowest, n) for (n, at), t in self._traces.items() if at == cell and t.pixels >= ENOUGH]
            for level, (_, number) in enumerate(sorted(seen), start=1):
                label = self._labels[number]
                things.append(Standing(label.kind, label.colour, label.look, *cell, level))
        return Room(tuple(things), dict(self._walls))

    def _add_walls(self, shown: npt.NDArray[np.uint16], column: _Floats, row: _Floats) -> None:
        """Takes in the walls: of each pixel of one (n,) its label, and where it is."""
        for number in np.unique(shown).tolist():
            is_own = shown == number
            if np.count_nonzero(is_own) >= ENOUGH:
                across, along = column[is_own], row[is_own]
                away = np.abs(np.stack([along, across, -along, -across]) - _WALLS[:, None]).mean(axis=1)
                self._walls.setdefault(self._labels[number].look, int(away.argmin()))


def _places(
    depth: npt.NDArray[np.float32],
    pixels: npt.NDArray[np.intp],
    scale: tuple[float, float],
    cell: Cell,
    heading: float,
) -> tuple[_Floats, _Floats, _Floats]:
    """Where some pixels' surfaces are: columns and rows with fractions, and heights in units; (n,) each."""
    focal, first = scale
    down, across = np.divmod(pixels, depth.shape[1])
    ahead = depth.ravel()[pixels].astype(np.float64)
    right = ahead * (across + first) / focal
    height = EYE_HEIGHT - ahead * (down + first) / focal
    sine, cosine = math.sin(math.radians(heading)), math.cos(math.radians(heading))
    column = cell[0] + (ahead * sine + right * cosine) / CELL
    row = cell[1] + (ahead * cosine - right * sine) / CELL
    return column, row, height


def _is_object(label: Label) -> bool:
    """Whether it is a collectible's: those alone have both a colour and a pattern."""
    return label.look in ("dotted", "striped") and bool(label.colour)
