"""The fast camera: a rasteriser compiled with numba that agrees with the reference camera, and has mipmaps."""

import math
import threading
from collections.abc import Sequence
from copy import copy
from functools import cache, lru_cache
from itertools import count
from typing import Any, NamedTuple, Self

import numpy as np
import numpy.typing as npt

from arramon_client.world import COLLECTIBLES, FIELD_OF_VIEW
from arramon_server.sim.assets.collectibles import mesh_of, texture_of
from arramon_server.sim.cameras import FAR, NEAR, Actor, Frame, Viewpoint, label_of, labels_of
from arramon_server.sim.catalogue import ALL_TYPES
from arramon_server.sim.daylight import AMBIENT, DIFFUSE, SUN, sky
from arramon_server.sim.identity_cache import IdentityCache
from arramon_server.sim.raster import compilation
from arramon_server.sim.raster.arrays import Bodies, FrameConstants, Integers, Scratch, Textures, new_scratch
from arramon_server.sim.raster.cover import cover
from arramon_server.sim.raster.paint import paint
from arramon_server.sim.raster.scene import LEVELS, geometry, indices_of, textures
from arramon_server.sim.room_scene import room_scene
from arramon_server.sim.scene import Scene

_FARTHEST = FAR / 1.001
"""Distance beyond which the reference camera draws nothing, in units."""

_ACTORS = 32
"""Number of actors for which buffers are allocated at first."""

_NO_DEPTH, _NO_UNITS, _NO_LABELS = np.empty(0, np.uint16), np.empty(0, np.float32), np.empty(0, np.uint16)
"""Outputs that are not drawn."""

_CACHED_POSES = 1024
"""Number of cached groups of actors, as arrays: they rarely change between the frames of an episode."""


class _Placed(NamedTuple):
    """Bodies of a scene as an array, with the number after their last polygon and the number of their clusters."""

    bodies: Bodies
    end: int
    clusters: int


class _Capacity(NamedTuple):
    """Capacity of scratch buffers: actors, polygons of bodies (up to `end`) and their clusters."""

    actors: int
    end: int
    clusters: int

    def holds(self, actors: int, placed: _Placed) -> bool:
        """Return whether a number of actors and these bodies fit."""
        return actors <= self.actors and placed.end <= self.end and placed.clusters <= self.clusters

    def joined(self, other: "_Capacity") -> "_Capacity":
        """Return the maximum of both capacities."""
        return _Capacity(*map(max, self, other))


class _Prepared(NamedTuple):
    """Data that a thread caches for a frame size."""

    constants: FrameConstants
    background: Integers
    scratch: Scratch
    capacity: _Capacity


class _ThreadCache(threading.local):
    """Cached data of each thread, by frame size."""

    def __init__(self) -> None:
        self.prepared: dict[int, _Prepared] = {}


class RasterCamera:
    """Rasteriser of one scene (`cameras.Camera`). Thread-safe, if each thread draws into its own arrays.

    Args:
        scene: the scene, without actors.
        mipmaps: whether distant surfaces use smaller textures; without them they are as noisy as in the reference.

    Raises:
        KeyError: for a body's mesh or texture that is not in the scene.
    """

    def __init__(self, scene: Scene, *, mipmaps: bool = True) -> None:
        self._labels = labels_of(scene)
        numbers, meshes, covers = indices_of(self._labels), indices_of(scene.meshes), indices_of(scene.textures)
        self._geometry = geometry([*scene.meshes.values(), *map(mesh_of, COLLECTIBLES)])
        self._textures = textures(list(scene.textures.values()))
        self._actor_textures = _collectible_textures()
        self._levels = LEVELS if mipmaps else 1
        ranges = self._geometry.clusters[self._geometry.meshes - [0, 1]]
        self._polygons = ranges[:, 1, 3] - ranges[:, 0, 1]
        self._numbers = meshes, covers, numbers
        self._placed = self._place(scene)
        self._most = int(self._polygons[-len(COLLECTIBLES) :].max())
        self._actor_looks = {
            type_: (len(meshes) + COLLECTIBLES.index(type_.kind), number, numbers[str(type_)])
            for number, type_ in enumerate(ALL_TYPES)
        }
        self._posed: IdentityCache[tuple[Actor, ...], Bodies] = IdentityCache(
            lru_cache(_CACHED_POSES)(self._pose), _CACHED_POSES
        )
        self._threads = _ThreadCache()

    @property
    def labels(self) -> tuple[str, ...]:
        """Labels of a segmentation, by number."""
        return self._labels

    def render(
        self,
        viewpoint: Viewpoint,
        actors: Sequence[Actor],
        size: int,
        *,
        segmentation: bool = False,
        into: Frame | None = None,
    ) -> Frame:
        """Draw a frame of `size` x `size` pixels from `viewpoint`, with `actors` in the scene for this frame only.

        The same arguments give the same bytes in every process, independent of earlier frames. Colours are written in
        words of four pixels, so `into` needs a size whose square is a multiple of 4.
        """
        placed = self._placed
        prepared = self._prepared(size, len(actors))
        depth: npt.NDArray[Any] = np.empty((size, size), np.uint16) if into is None else into.depth
        words = np.empty(-(-size * size // 4) * 3, np.int32) if into is None else into.rgb.reshape(-1).view(np.int32)
        in_units = depth.dtype == np.float32
        labels = None if into is None else into.segmentation
        if labels is None and segmentation:
            labels = np.empty((size, size), np.uint16)
        view = float(viewpoint.x), float(viewpoint.y), float(viewpoint.z), *_turn(viewpoint.heading)
        places, actor_places = self._textures.places, self._actor_textures.places
        posed = self._posed(tuple(actors), placed.end)
        cover(view, prepared.constants, self._geometry, places, placed.bodies, actor_places, posed, prepared.scratch)
        paint(
            prepared.constants,
            self._textures,
            self._actor_textures,
            prepared.background,
            prepared.scratch,
            words,
            _NO_DEPTH if in_units else depth.ravel(),
            depth.ravel() if in_units else _NO_UNITS,
            _NO_LABELS if labels is None else labels.ravel(),
        )
        rgb = words.view(np.uint8)[: 3 * size * size].reshape(size, size, 3) if into is None else into.rgb
        return Frame(rgb, depth, labels if segmentation else None)

    def showing(self, scene: Scene) -> Self:
        """Return a camera that draws the bodies of another scene, with the meshes and textures of this one."""
        other = copy(self)
        other._placed = self._place(scene)
        return other

    def _place(self, scene: Scene) -> _Placed:
        """Return the bodies of a scene as an array for the compiled code.

        Raises:
            KeyError: for a mesh, texture or label that is not in the camera's own scene.
        """
        meshes, covers, numbers = self._numbers
        rows, end = [], 1
        for body in scene.bodies:
            mesh = meshes[body.mesh]
            look = mesh, covers[body.texture], numbers[label_of(body)], end
            rows.append((*body.position, *_turn(body.heading), body.scale, *look))
            end += int(self._polygons[mesh])
        bodies = _bodies(rows)
        each = self._geometry.meshes[:, 1] - self._geometry.meshes[:, 0]
        return _Placed(bodies, end, int(each[bodies[:, 6].astype(int)].sum()))

    def _pose(self, actors: tuple[Actor, ...], first: int) -> Bodies:
        """Return actors as an array for the compiled code, their polygons numbered from `first`."""
        return _bodies(
            [
                (*actor.position, *_turn(actor.heading), actor.scale, *self._actor_looks[actor.type], first + i)
                for i, actor in zip(count(0, self._most), actors, strict=False)
            ]
        )

    def _prepared(self, size: int, actors: int) -> _Prepared:
        """Return this thread's cached data for a frame size, with enough capacity for the actors and bodies."""
        mine, placed = self._threads.prepared, self._placed
        if size not in mine or not mine[size].capacity.holds(actors, placed):
            capacity = _Capacity(max(_ACTORS, 2 * actors), placed.end, placed.clusters)
            if size in mine:
                capacity = capacity.joined(mine[size].capacity)
            mine[size] = _Prepared(
                _frame_constants(size, self._levels),
                _packed(sky(size)),
                self._scratch(size, capacity),
                capacity,
            )
        return mine[size]

    def _scratch(self, size: int, capacity: _Capacity) -> Scratch:
        flat = self._geometry
        each = flat.meshes[:, 1] - flat.meshes[:, 0]
        clusters = capacity.clusters + capacity.actors * int(each[-len(COLLECTIBLES) :].max())
        points = int((flat.clusters[:, 2] - flat.clusters[:, 0]).max())
        polygons = capacity.end + capacity.actors * self._most
        return new_scratch(size, polygons, clusters, points, int(flat.shapes[:, 1].max()))


def is_compiled() -> bool:
    """Return whether the kernels are already compiled, in this process or on disk, so that the first frame is fast."""
    return compilation.is_compiled(cover) and compilation.is_compiled(paint)


def compile_kernels() -> None:
    """Compile the kernels, which takes seconds, or load them from disk if they were compiled before."""
    RasterCamera(room_scene()).render(Viewpoint(0.0, 0.0, 0.0), [], 8)


def _turn(heading: float) -> tuple[float, float]:
    angle = math.radians(heading)
    return math.cos(angle), math.sin(angle)


def _bodies(rows: Sequence[tuple[float, ...]]) -> Bodies:
    return np.array(rows, np.float64).reshape(-1, 10)


def _frame_constants(size: int, levels: int) -> FrameConstants:
    sun = math.hypot(*SUN)
    focal = size / 2 / math.tan(math.radians(FIELD_OF_VIEW) / 2)
    x, y, z = SUN
    return FrameConstants(size, levels, focal, NEAR, _FARTHEST, AMBIENT, DIFFUSE, (x / sun, y / sun, z / sun))


def _packed(image: npt.NDArray[np.uint8]) -> Integers:
    return (image.astype(np.int32) @ np.array([1, 1 << 8, 1 << 16], np.int32)).reshape(-1)


@cache
def _collectible_textures() -> Textures:
    """Return the textures of all types, in the catalogue's order; cameras share them."""
    return textures([texture_of(type_) for type_ in ALL_TYPES])
