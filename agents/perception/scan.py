"""Obstacles, free ground and landmarks of a frame, from depth and segmentation, in the agent's own frame.

In its own frame, the agent starts at (0, 0) facing +z; x is to the right; both are in units.
"""

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from functools import cache

import numpy as np
import numpy.typing as npt

from arramon_client.agent import Label
from arramon_client.world import COLLECTIBLES, EYE_HEIGHT, FIELD_OF_VIEW

Floats = npt.NDArray[np.float32]

MIN_OBSTACLE_HEIGHT, MAX_OBSTACLE_HEIGHT = 0.05, 0.62
"""Range of heights in which an object is an obstacle, in units."""

MAX_DISTANCE = 20.0
"""Maximum distance of obstacles that are recorded, in units."""

SAMPLES = 112
"""Number of rows and columns of a frame that are sampled: every second pixel of the usual 224."""

FREE_POINT_DISTANCES = np.arange(0.125, 16.0, 0.25, dtype=np.float32)
"""Distances ahead of the points at which the ground is recorded as free, in units."""

SIGHTING_SQUARE = 1.5
"""Side of the squares in which pixels of one label form one sighting, in units."""

GROUND = ("nothing", "road", "pavement", "roof", "floor", "start_tile", "ceiling")
NOT_SOLID = ("banner", "awning", "shop_sign", "zebra_crossing")


@dataclass(frozen=True, slots=True)
class Sighting:
    """A part of an object as seen in one frame.

    Attributes:
        label: index in the table of labels.
        x, z: mean position of its pixels, in the agent's own frame.
        distance: distance from the camera, in units.
        pixels: number of samples that show it.
    """

    label: int
    x: float
    z: float
    distance: float
    pixels: int


@dataclass(frozen=True, eq=False)
class Scan:
    """Obstacles and free ground of a frame, in the agent's own frame.

    Attributes:
        obstacles: (n, 2) of (x, z): points of obstacles.
        walls: (n,) whether each of them belongs to a building.
        free: (m, 2) of (x, z): points of free ground.
    """

    obstacles: Floats
    walls: npt.NDArray[np.bool_]
    free: Floats


@dataclass(eq=False)
class FrameScanner:
    """Extracts obstacles, free ground and landmarks from frames.

    Args:
        labels: labels of the segmentation, by index.
        landmark_labels: indices of the labels of which there are sightings; None for all.
    """

    labels: Sequence[Label]
    landmark_labels: Collection[int] | None = None
    solid: npt.NDArray[np.bool_] = field(init=False)
    building: npt.NDArray[np.bool_] = field(init=False)
    thing: npt.NDArray[np.bool_] = field(init=False)

    def __post_init__(self) -> None:
        kinds = [label.kind for label in self.labels]
        self.solid = np.array([kind not in (*GROUND, *COLLECTIBLES, *NOT_SOLID) for kind in kinds])
        self.building = np.array([kind == "building" for kind in kinds])
        self.thing = np.array([kind not in (*GROUND, "building", "wall") for kind in kinds])
        if self.landmark_labels is not None:
            self.thing &= np.isin(np.arange(len(kinds)), list(self.landmark_labels))

    def scan(self, depth: Floats, segmentation: npt.NDArray[np.uint16], pose: tuple[float, float, float]) -> Scan:
        """Return a frame's obstacles and free ground.

        Args:
            depth: (size, size) units along the viewing direction, 0 where nothing was hit.
            segmentation: (size, size) indices in the table of labels.
            pose: (x, z, radians clockwise) of the camera in the agent's own frame.
        """
        lens = _lens(len(depth))
        z = depth[lens.low, lens.sparse]
        seen = segmentation[lens.low, lens.sparse]
        height = EYE_HEIGHT - lens.low_down[:, None] * z
        solid = self.solid[seen]
        solid &= height > MIN_OBSTACLE_HEIGHT
        solid &= height < MAX_OBSTACLE_HEIGHT
        solid &= z > 0.0
        near = np.where(solid, z, np.float32(MAX_DISTANCE)).min(axis=0)
        solid &= z < MAX_DISTANCE
        rows, columns = np.nonzero(solid)
        ahead = z[rows, columns]
        obstacles = _to_own_frame(lens.sparse_right[columns] * ahead, ahead, pose)
        walls = self.building[seen[rows, columns]]
        columns, steps = np.nonzero(lens.beams < near[:, None])
        ahead = FREE_POINT_DISTANCES[steps]
        return Scan(obstacles, walls, _to_own_frame(lens.sparse_right[columns] * ahead, ahead, pose))

    def sightings(
        self, depth: Floats, segmentation: npt.NDArray[np.uint16], pose: tuple[float, float, float]
    ) -> list[Sighting]:
        """Return the objects in view, and the buildings at eye height; arguments as for `scan`."""
        lens = _lens(len(depth))
        z, seen = depth[lens.samples, lens.samples], segmentation[lens.samples, lens.samples]
        shown = self.thing[seen]
        shown[lens.horizon] |= self.building[seen[lens.horizon]]
        shown &= z > 0.0
        rows, columns = np.nonzero(shown)
        if not len(rows):
            return []
        ahead, labels = z[rows, columns], seen[rows, columns].astype(np.int64)
        places = _to_own_frame(lens.right[columns] * ahead, ahead, pose)
        cells = np.floor(places / SIGHTING_SQUARE).astype(np.int64) + 512
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
    """Sampled pixels of a frame, and the directions of their rays, in units per unit ahead.

    Attributes:
        samples: rows, and columns, sampled for objects.
        right: (columns,) offsets to the right of the sampled columns' rays.
        horizon: the sample row at eye height.
        low, low_down: rows that can show obstacles, and the downward offsets of their rays.
        sparse, sparse_right: columns sampled for obstacles, and the offsets to the right of their rays.
        beams: (columns, steps) distances ahead of the points tested for free ground, one beam per column.
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
    beams = np.broadcast_to(FREE_POINT_DISTANCES, (len(rays[sparse]), len(FREE_POINT_DISTANCES)))
    return _Lens(
        samples, rays[samples], size // 2 // every, low, rays[low], sparse, rays[sparse], np.ascontiguousarray(beams)
    )


def _to_own_frame(right: Floats, ahead: Floats, pose: tuple[float, float, float]) -> Floats:
    """Return (n, 2) positions in the agent's own frame of places to the right and ahead of the camera."""
    x, z, heading = pose
    sin, cos = math.sin(heading), math.cos(heading)
    return np.stack([x + right * cos + ahead * sin, z - right * sin + ahead * cos], axis=1)
