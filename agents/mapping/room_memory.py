"""Memory of the assembly room: its contents, reconstructed from depth and segmentation with known camera poses."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import permutations
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from arramon_client.agent import Label
from arramon_client.world import CELL_SIZE, COLUMNS, EYE_HEIGHT, FIELD_OF_VIEW, ROWS
from arramon_lang.cell_grading import Cell, Room, RoomObject

if TYPE_CHECKING:
    from arramon_agents.perception.eyes.detected_things import DetectedThing  # It needs PyTorch.

MIN_PIXELS = 4
"""Minimum number of pixels of an object or wall, over all frames; fewer may be the edge of another object."""

MAX_SAMPLES = 112
"""Maximum number of rows and columns examined; larger frames are subsampled."""

_WALLS = np.array([ROWS - 0.5, COLUMNS - 0.5, 0.5, 0.5])
"""Distance of each wall from the centre of cell (0, 0), in cells: towards +row, +column, -row, -column."""


_Floats = npt.NDArray[np.float64]


@dataclass(slots=True)
class _Evidence:
    """Evidence for one type of object in one cell: number of pixels, and lowest height in units."""

    pixels: int
    lowest: float


class RoomMemory:
    """Accumulates frames of the room and reconstructs its contents.

    Args:
        labels: labels of the segmentation, by index (`Episode.labels`).

    Raises:
        ValueError: if there are no labels, because the run lacks the sensor "segmentation".
    """

    def __init__(self, labels: Sequence[Label]) -> None:
        if not labels:
            raise ValueError('the episode has no labels; the room follower requires the sensor "segmentation"')
        self._labels = tuple(labels)
        self._is_object = np.array([_is_object(label) for label in labels])
        self._is_wall = np.array([label.kind == "wall" for label in labels])
        self._traces: dict[tuple[int, Cell], _Evidence] = {}
        self._wall_pixels: dict[str, npt.NDArray[np.int64]] = {}

    def add(
        self, depth: npt.NDArray[np.float32], segmentation: npt.NDArray[np.uint16], cell: Cell, heading: float
    ) -> None:
        """Add one frame.

        Args:
            depth: (size, size), units along the viewing direction, 0 where nothing was hit.
            segmentation: (size, size), each pixel's index in the labels.
            cell: (column, row) of the camera.
            heading: heading of the camera in degrees clockwise from +row.
        """
        size = depth.shape[0]
        step = max(1, size // MAX_SAMPLES)
        depth, shown = depth[::step, ::step], segmentation[::step, ::step].ravel()
        # Focal length in pixels, and the first pixel's offset from the image's centre.
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
            trace = self._traces.setdefault((label, divmod(place, ROWS)), _Evidence(0, math.inf))
            trace.pixels += count
            trace.lowest = min(trace.lowest, low)
        every = np.flatnonzero(self._is_wall[shown])
        column, row, _ = _places(depth, every, scale, cell, heading)
        self._add_walls(shown[every], column, row)

    def add_things(self, things: Sequence["DetectedThing"], cell: Cell, heading: float) -> None:
        """Ignore the detected things of a frame: objects come from the segmentation only."""

    def room(self) -> Room:
        """Return the room as seen so far; objects in one cell are stacked, ordered by height."""
        things = []
        cells = sorted({cell for (_, cell), trace in self._traces.items() if trace.pixels >= MIN_PIXELS})
        for cell in cells:
            seen = [(t.lowest, n) for (n, at), t in self._traces.items() if at == cell and t.pixels >= MIN_PIXELS]
            for level, (_, number) in enumerate(sorted(seen), start=1):
                label = self._labels[number]
                things.append(RoomObject(label.kind, label.colour, label.look, *cell, level))
        return Room(tuple(things), _walls_of(self._wall_pixels))

    def _add_walls(self, shown: npt.NDArray[np.uint16], column: _Floats, row: _Floats) -> None:
        """Add wall pixels, each to the wall nearest to it: (n,) labels, and (n,) columns and rows with fractions."""
        nearest = np.abs(np.stack([row, column, -row, -column]) - _WALLS[:, None]).argmin(axis=0)
        for number in np.unique(shown).tolist():
            counts = self._wall_pixels.setdefault(self._labels[number].look, np.zeros(len(_WALLS), np.int64))
            counts += np.bincount(nearest[shown == number], minlength=len(_WALLS))


def _walls_of(pixels: Mapping[str, npt.NDArray[np.int64]]) -> dict[str, int]:
    """Return the quarter of each wall that was seen, given the pixels of each look by quarter.

    A few pixels of a wall may show another look, so walls and looks are paired as most pixels have it. No two walls
    look alike.
    """
    looks = sorted(pixels, key=lambda look: int(pixels[look].sum()), reverse=True)[: len(_WALLS)]
    looks = [look for look in looks if pixels[look].sum() >= MIN_PIXELS]
    quarters = max(
        permutations(range(len(_WALLS)), len(looks)),
        key=lambda order: sum(int(pixels[look][quarter]) for look, quarter in zip(looks, order, strict=True)),
    )
    return dict(zip(looks, quarters, strict=True))


def _places(
    depth: npt.NDArray[np.float32],
    pixels: npt.NDArray[np.intp],
    scale: tuple[float, float],
    cell: Cell,
    heading: float,
) -> tuple[_Floats, _Floats, _Floats]:
    """Return the positions of pixels: columns and rows with fractions, and heights in units; (n,) each."""
    focal, first = scale
    down, across = np.divmod(pixels, depth.shape[1])
    ahead = depth.ravel()[pixels].astype(np.float64)
    right = ahead * (across + first) / focal
    height = EYE_HEIGHT - ahead * (down + first) / focal
    sine, cosine = math.sin(math.radians(heading)), math.cos(math.radians(heading))
    column = cell[0] + (ahead * sine + right * cosine) / CELL_SIZE
    row = cell[1] + (ahead * cosine - right * sine) / CELL_SIZE
    return column, row, height


def _is_object(label: Label) -> bool:
    """Return whether a label is a collectible's: only these have both a colour and a pattern."""
    return label.look in ("dotted", "striped") and bool(label.colour)
