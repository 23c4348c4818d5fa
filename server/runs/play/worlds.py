"""Cache of scenes, collision checks and cameras: one of each per section, shared by its episodes, and one for the room.

An episode with its own furniture has a variation of its section's scene, for which the same camera and checks are used.
"""

import threading
from collections import OrderedDict
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from arramon_server.episodes.episode import Episode
from arramon_server.episodes.splits import Split
from arramon_server.sim.cameras import CAMERAS, Camera, Frame
from arramon_server.sim.city import city_scene, refurnished
from arramon_server.sim.labels import places_of
from arramon_server.sim.own_furniture import OwnFurniture, furnished
from arramon_server.sim.physics import WITH_PYBULLET, Physics, VariedCollisionCheck, physics_of, reference_camera_of
from arramon_server.sim.raster.camera import RasterCamera
from arramon_server.sim.room_scene import room_scene
from arramon_server.sim.rules import CollisionCheck, State
from arramon_server.sim.scene import Scene
from arramon_server.sim.section import Prop, Section
from arramon_server.sim.variations import CACHED, SceneDifference
from arramon_server.sim.view import view

if TYPE_CHECKING:
    from arramon_server.sim.bullet import ReferenceCamera

Key = tuple[str, str]
"""Split and section id of a section; equal sections share the first key."""


@dataclass(frozen=True, eq=False)
class _Variation:
    """The scene of an episode with its own furniture, and its difference from the section's scene."""

    furniture: OwnFurniture
    scene: Scene
    difference: SceneDifference


class Worlds:
    """Scenes, collision checks and cameras by section; splits with equal sections share them.

    Not thread-safe, except for `render` with a camera that `draws_in_threads`: several threads may draw at once.

    Args:
        splits: splits by name.
        camera: one of `cameras.CAMERAS`; the one that needs pybullet checks collisions, too.
        physics: makes the collision checks of a scene. All kinds give equal answers (`rules.CollisionCheck`).
    """

    def __init__(
        self,
        splits: Mapping[str, Split],
        camera: str = CAMERAS[0],
        physics: Callable[[Scene], Physics] = physics_of,
    ) -> None:
        self._splits = splits
        self._physics = physics
        first: dict[Section, Key] = {}
        self._shared_keys = {
            (split.name, id_): first.setdefault(section, (split.name, id_))
            for split in splits.values()
            for id_, section in split.sections.items()
        }
        """By split and section, the first split and section that is equal to it."""
        self._camera = camera
        self._scenes: dict[Key, Scene] = {}
        self._collision_checks: dict[Key, Physics] = {}
        self._worlds: dict[Key | None, ReferenceCamera] = {}
        self._cameras: dict[Key | None, Camera] = {}
        self._label_indices: dict[Key | None, npt.NDArray[np.uint16]] = {}
        self._variations: OrderedDict[tuple[str, str], _Variation] = OrderedDict()
        self._cache_lock = threading.Lock()
        """Held while a thread that draws looks for a camera or a variation, or makes it."""

    @property
    def draws_in_threads(self) -> bool:
        """Whether several threads may draw at once."""
        return self._camera == "raster"

    def scene(self, split: str, episode: Episode) -> Scene:
        """Return the scene of an episode: its section with the episode's own furniture."""
        variation = self._variation(split, episode)
        return self._section_scene(self._shared_keys[split, episode.section]) if variation is None else variation.scene

    def collision_check(self, split: str, episode: Episode) -> CollisionCheck:
        """Return the collision check of an episode's scene."""
        obstacles = self._obstacles(self._shared_keys[split, episode.section])
        variation = self._variation(split, episode)
        return obstacles if variation is None else VariedCollisionCheck(obstacles, variation.difference)

    def render(
        self,
        split: str,
        episode: Episode,
        state: State,
        size: int,
        *,
        segmentation: bool = False,
        into: Frame | None = None,
    ) -> Frame:
        """Draw the agent's view in a state of an episode.

        Args:
            split: name of the episode's split.
            episode: the episode.
            state: its state.
            size: side length of the images, in pixels.
            segmentation: whether to label each pixel with its index in `arramon_server.sim.labels.LABELS`.
            into: arrays to draw into, as for `cameras.Camera.render`, but for the segmentation, which is always new.
        """
        seen = view(state, episode.layout)
        key = None if seen.indoors else self._shared_keys[split, episode.section]
        with self._cache_lock:
            if key not in self._cameras:
                made = self._build_camera(key)
                self._cameras[key], self._label_indices[key] = made, places_of(made.labels)
            variation = None if seen.indoors else self._variation(split, episode)
        frame = self._cameras[key].render(
            seen.viewpoint,
            seen.actors,
            size,
            segmentation=segmentation,
            into=into,
            variation=None if variation is None else variation.scene,
        )
        if frame.segmentation is None:
            return frame
        return replace(frame, segmentation=self._label_indices[key][frame.segmentation])

    def close(self) -> None:
        """Free all worlds."""
        for physics in (*self._collision_checks.values(), *self._worlds.values()):
            physics.close()
        self._collision_checks.clear()
        self._worlds.clear()
        self._cameras.clear()
        self._variations.clear()

    def _variation(self, split: str, episode: Episode) -> _Variation | None:
        """Return the variation of an episode, cached; None if the episode has no furniture of its own."""
        furniture = episode.furniture
        if furniture.is_empty:
            return None
        found = self._variations.get((split, episode.episode_id))
        if found is not None and found.furniture is furniture:
            return found
        base = self._section_scene(self._shared_keys[split, episode.section])
        scene = refurnished(base, furnished(self._splits[split].sections[episode.section], furniture))
        made = _Variation(furniture, scene, SceneDifference.between(base, scene))
        self._variations[split, episode.episode_id] = made
        if len(self._variations) > CACHED:
            self._variations.popitem(last=False)
        return made

    def _section_scene(self, key: Key) -> Scene:
        """Return the scene of a section, with spare bodies for every look of its episodes' own furniture."""
        if key not in self._scenes:
            self._scenes[key] = city_scene(self._splits[key[0]].sections[key[1]], self._furniture_looks(key))
        return self._scenes[key]

    def _furniture_looks(self, key: Key) -> list[Prop]:
        """Return one prop for each look of the episodes' own furniture in a section, over all splits that have it."""
        looks: dict[tuple[str, str, str, str], Prop] = {}
        for split in self._splits.values():
            for episode in split.episodes.values():
                if episode.furniture.added and self._shared_keys[split.name, episode.section] == key:
                    for prop in episode.furniture.added:
                        looks.setdefault((prop.kind, prop.colour, prop.shape, prop.shape_colour), prop)
        return [looks[look] for look in sorted(looks)]

    def _obstacles(self, key: Key) -> Physics:
        if self._camera == WITH_PYBULLET:
            return self._world(key)
        if key not in self._collision_checks:
            self._collision_checks[key] = self._physics(self._section_scene(key))
        return self._collision_checks[key]

    def _world(self, key: Key | None) -> "ReferenceCamera":
        """Return the reference camera of a section or of the room, which also checks collisions."""
        if key not in self._worlds:
            self._worlds[key] = reference_camera_of(room_scene() if key is None else self._section_scene(key))
        return self._worlds[key]

    def _build_camera(self, key: Key | None) -> Camera:
        """Build the camera of a section or of the room."""
        if self._camera == WITH_PYBULLET:
            return self._world(key)
        return RasterCamera(room_scene() if key is None else self._section_scene(key))
