"""What a frame shows, in the agent's own frame: what stands in the way, how far the way is free, and the landmarks.

The agent's own frame: it began at (0, 0) facing +z; x runs to the right of that, both in units.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache

import numpy as np
import numpy.typing as npt

from arramon_client.agent import Label

Floats = npt.NDArray[np.float32]

FIELD_OF_VIEW = 60.0
"""Degrees, vertical and horizontal: frames are square."""

EYE_HEIGHT = 0.525
LOWEST, HIGHEST = 0.05, 0.62
"""Heights between which a thing stands in the agent's way, in units."""

FARTHEST = 20.0
"""How far what stands in the way is noted, in units."""

SAMPLES = 112
"""Rows and columns of a frame that are looked at: every second pixel of the usual 224."""

BEAM = np.arange(0.125, 16.0, 0.25, dtype=np.float32)
"""How far ahead the points are, one after the other, at which the ground is noted as free, in units."""

CLUSTER = 1.5
"""Pixels of one label in one square of this side, in units, are one sighting."""

GROUND = ("nothing", "road", "pavement", "roof", "floor", "start_tile")
COLLECTIBLES = ("ball", "hourglass", "mug", "tv", "book", "bowl", "bucket")


@dataclass(frozen=True, slots=True)
class Sighting:
    """A part of a thing as one frame shows it.

    Attributes:
        label: its place in the table of labels.
        x, z: the middle of what is seen of it, in the agent's own frame.
        distance: from the eye, in units.
        pixels: how many of the samples show it.
    """

    label: int
    x: float
    z: float
    distance: float
    pixels: int


@dataclass(frozen=True, eq=False)
class Scan:
    """A frame's geometry in the agent's own frame.

    Attributes:
        obstacles: (n, 2) of (x, z): points of what stands in the way.
        walls: (n,) whether each of them belongs to a building.
        free: (m, 2) of (x, z): points on the ground where nothing stands in the way.
    """

    obstacles: Floats
    walls: npt.NDArray[np.bool_]
    free: Floats


@dataclass(eq=False)
class Eye:
    """Reads frames by a table of labels.

    Args:
        labels: what the numbers of a segmentation mean.
    """

    labels: Sequence[Label]
    solid: npt.NDArray[np.bool_] = field(init=False)
    building: npt.NDArray[np.bool_] = field(init=False)
    thing: npt.NDArray[np.bool_] = field(init=False)

    def __post_init__(self) -> None:
        kinds = [label.kind for label in self.labels]
        self.solid = np.array([kind not in (*GROUND, *COLLECTIBLES, "banner") for kind in kinds])
        self.building = np.array([kind == "building" for kind in kinds])
        self.thing = np.array([kind not in (*GROUND, "building", "wall") for kind in kinds])

    def scan(self, depth: Floats, segmentation: npt.NDArray[np.uint16], pose: tuple[float, float, float]) -> Scan:
        """What stands in the way.

        Args:
            depth: (size, size) units along the viewing direction, 0 where nothing was hit.
            segmentation: (size, size) places in the table of labels.
            pose: (x, z, radians clockwise) of the eye in the own frame.
        """
        lens = _lens(len(depth))
        z = depth[lens.low, lens.sparse]
        seen = segmentation[lens.low, lens.sparse]
        height = EYE_HEIGHT - lens.low_down[:, None] * z
        solid = self.solid[seen]
        solid &= height > LOWEST
        solid &= height < HIGHEST
        solid &= z > 0.0
        near = np.where(solid, z, np.float32(FARTHEST)).min(axis=0)
        solid &= z < FARTHEST
        rows, columns = np.nonzero(solid)
        ahead = z[rows, columns]
        obstacles = _own(lens.sparse_right[columns] * ahead, ahead, pose)
        walls = self.building[seen[rows, columns]]
        columns, steps = np.nonzero(lens.beams < near[:, None])
        ahead = BEAM[steps]
        return Scan(obstacles, walls, _own(lens.sparse_right[columns] * ahead, ahead, pose))

    def sightings(
        self, depth: Floats, segmentation: npt.NDArray[np.uint16], pose: tuple[float, float, float]
    ) -> list[Sighting]:
        """The things in view, and the buildings at eye height; arguments as of `scan`."""
        lens = _lens(len(depth))
        z, seen = depth[lens.samples, lens.samples], segmentation[lens.samples, lens.samples]
        shown = self.thing[seen]
        shown[lens.horizon] |= self.building[seen[lens.horizon]]
        shown &= z > 0.0
        rows, columns = np.nonzero(shown)
        if not len(rows):
            return []
        ahead, labels = z[rows, columns], seen[rows, columns].astype(np.int64)
        places = _own(lens.right[columns] * ahead, ahead, pose)
        cells = np.floor(places / CLUSTER).astype(np.int64) + 512
        keys = (labels << 20) | (cells[:, 0] << 10) | cells[:, 1]
        unique, inverse, counts = np.unique(keys, return_inverse=True, return_counts=True)
        inverse = inverse.ravel()
        xs = np.bincount(inverse, places[:, 0]) / counts
        zs = np.bincount(inverse, places[:, 1]) / counts
        return [
            Sighting(key >> 20, x, z_, math.hypot(x - pose[0], z_ - pose[1]), count)
            for key, x, z_, count in zip(unique.tolist(), xs.tolist(), zs.tolist(), counts.tolist(), strict=True)
        ]


@dataclass(frozen=True, eq=False)
class _Lens:
    """Which pixels of a frame are looked at, and where their rays go, in units for each unit ahead.

    Attributes:
        samples: rows, and columns, where things are looked for.
        right: (columns,) of the samples.
        horizon: the sample row at eye height.
        low, low_down: rows where something can stand in the way, and how far their rays go down.
        sparse, sparse_right: columns where that is looked for.
        beams: (columns, steps) how far ahead the points are at which the ground is taken for free, one beam a column.
    """

    samples: slice
    right: Floats
    horizon: int
    low: slice
    low_down: Floats
    sparse: slice
    sparse_right: Floats
    beams: Floats


@cache
def _lens(size: int) -> _Lens:
    every = max(1, size // SAMPLES)
    focal = size / 2 / math.tan(math.radians(FIELD_OF_VIEW / 2))
    rays = ((np.arange(size) + 0.5 - size / 2) / focal).astype(np.float32)
    samples, sparse = slice(None, None, every), slice(None, None, 2 * every)
    low = slice(size // 2 - 4 * every, None, every)
    beams = np.broadcast_to(BEAM, (len(rays[sparse]), len(BEAM)))
    return _Lens(
        samples, rays[samples], size // 2 // every, low, rays[low], sparse, rays[sparse], np.ascontiguousarray(beams)
    )


def _own(right: Floats, ahead: Floats, pose: tuple[float, float, float]) -> Floats:
    """(n, 2): places given to the right and ahead of the eye, in the own frame."""
    x, z, heading = pose
    sin, cos = math.sin(heading), math.cos(heading)
    return np.stack([x + right * cos + ahead * sin, z - right * sin + ahead * cos], axis=1)
