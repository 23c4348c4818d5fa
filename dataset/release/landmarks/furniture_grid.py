"""A grid of places where furniture may stand in a rebuilt section, with clearances and lines of sight."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from arramon_dataset.layout.grid import sample_points
from arramon_dataset.layout.prop_places import PATH_GAP, TARGET_GAP
from arramon_dataset.layout.solids import Solids
from arramon_dataset.release.landmarks.turn_paths import Numbers
from arramon_server.episodes.episode import Episode
from arramon_server.sim.assets.furniture import footprint_radius
from arramon_server.sim.section import Building

Mask = npt.NDArray[np.bool_]

SPACING = 0.5
"""Distance between places, in units."""

WALKABLE = 4.0
"""Maximum distance of furniture from paths, in units: farther places are seldom visible."""

APART = 0.3
"""Minimum distance between the circles around two pieces of furniture, in units."""

FAR = 8.0
"""Maximum distance from paths and objects that is computed, in units; nothing depends on larger ones."""

FEW = 100
"""Number of places below which distances from all props are computed at once, which is slower for more."""

_RASTER = 0.25


@dataclass(frozen=True, eq=False)
class FurnitureGrid:
    """Places for furniture in a section, and its buildings as a raster.

    Attributes:
        heading: of the streets, degrees clockwise from +z.
        places: (g, 2) of (x, z), clear of buildings.
        clearance: (g,) distance of each from the nearest building, in units.
        low: (2,) of (x, z), the raster's corner.
        built: (rows along x, columns along z), whether there is a building.
    """

    heading: float
    places: Numbers
    clearance: Numbers
    low: Numbers
    built: Mask

    @classmethod
    def of(cls, heading: float, buildings: Sequence[Building], walked: Numbers) -> "FurnitureGrid":
        """Return the grid of places around walked positions (n, 2) of (x, z), clear of buildings."""
        solids = Solids.from_bodies(buildings)
        low, high = np.floor(walked.min(axis=0) - WALKABLE), np.ceil(walked.max(axis=0) + WALKABLE)
        raster = _lattice(low, high, _RASTER)
        shape = raster.shape[:2]
        built: Mask = np.asarray(solids.distance(raster.reshape(-1, 2)).reshape(shape) <= 0.0)
        places = _lattice(low, high, SPACING).reshape(-1, 2)
        clearance = solids.distance(places)
        tree = cKDTree(np.unique(walked.round(1), axis=0))
        free: Mask = (clearance > 0.0) & (tree.query(places, distance_upper_bound=WALKABLE)[0] < WALKABLE)
        return cls(heading, places[free], clearance[free], low, built)

    def sees(self, origin: Numbers, places: Numbers) -> Mask:
        """Return which places (m, 2) have no building between them and an origin (2,), (m,)."""
        fractions = np.linspace(0.0, 1.0, 48)[:, None, None]
        points = origin + fractions * (places - origin)
        cells = np.floor((points - self.low) / _RASTER).astype(np.intp)
        inside = ((cells >= 0) & (cells < np.array(self.built.shape))).all(axis=2)
        row, column = np.where(inside, cells[..., 0], 0), np.where(inside, cells[..., 1], 0)
        seen: Mask = ~np.any(self.built[row, column] & inside, axis=0)
        return seen


@dataclass(frozen=True, eq=False)
class FreeSpace:
    """Ground of a section that one episode's paths and objects leave free.

    Attributes:
        ground: of the section.
        walked: (n, 2), closely spaced points on its paths.
        targets: (2, 2), the objects to pick up.
        distracters: (m, 2), the other objects in its streets.
        from_path: (g,), distance of each place of the ground from the paths, in units; infinite from FAR on.
        from_object: (g,), the same from the nearest object.
    """

    ground: FurnitureGrid
    walked: Numbers
    targets: Numbers
    distracters: Numbers
    from_path: Numbers
    from_object: Numbers

    @classmethod
    def of(cls, episode: Episode, ground: FurnitureGrid) -> "FreeSpace":
        """Return the free ground of an episode."""
        walked = sample_points([np.array(turn.path) for turn in episode.turns], 0.2)
        positions = [[(each.position.x, each.position.z) for each in turn.street] for turn in episode.turns]
        targets = np.array([street[0] for street in positions])
        distracters = np.array([place for street in positions for place in street[1:]]).reshape(-1, 2)
        objects = np.concatenate([targets, distracters])
        path, street = (
            cKDTree(points).query(ground.places, distance_upper_bound=FAR)[0] for points in (walked, objects)
        )
        return cls(ground, walked, targets, distracters, path, street)

    @property
    def objects(self) -> Numbers:
        """All objects in its streets, (k, 2)."""
        return np.concatenate([self.targets, self.distracters])

    def free_for(self, kind: str) -> Mask:
        """Return the places (g,) where a thing of a kind blocks neither a path nor an object."""
        radius = footprint_radius(kind)
        free: Mask = self.ground.clearance > radius
        free &= self.from_path >= PATH_GAP + radius
        return free & (self.from_object >= TARGET_GAP + radius)


def apart_from(places: Numbers, kind: str, standing: Sequence[tuple[float, float, str]]) -> Mask:
    """Return which places (m, 2) keep a thing of a kind clear of all others (x, z, kind), (m,)."""
    gaps = np.array([footprint_radius(kind) + footprint_radius(other) + APART for _, _, other in standing])
    spots = np.array([(x, z) for x, z, _ in standing]).reshape(-1, 2)
    if len(places) < FEW:
        offsets = places[:, None] - spots
        apart: Mask = (np.hypot(offsets[..., 0], offsets[..., 1]) >= gaps).all(axis=1)
        return apart
    clear = np.ones(len(places), dtype=bool)
    for (x, z), gap in zip(spots, gaps, strict=True):
        clear &= np.hypot(places[:, 0] - x, places[:, 1] - z) >= gap
    return clear


def _lattice(low: Numbers, high: Numbers, spacing: float) -> Numbers:
    """Return the middles of the cells between two corners, (rows along x, columns along z, 2)."""
    x, z = (np.arange(low[axis], high[axis] - spacing / 2, spacing) + spacing / 2 for axis in (0, 1))
    return np.stack(np.meshgrid(x, z, indexing="ij"), axis=2)
