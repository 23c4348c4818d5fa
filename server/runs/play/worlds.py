"""Scenes, pybullet worlds and cameras: one of each per section, shared by its episodes, and one room."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from server.episodes.episode import Episode
from server.episodes.splits import Split
from server.sim.bullet import Obstacles, World
from server.sim.cameras import CAMERAS, Camera, Frame
from server.sim.city import city_scene
from server.sim.labels import places_of
from server.sim.raster.camera import RasterCamera
from server.sim.room_scene import room_scene
from server.sim.rules import Ground, State
from server.sim.scene import Scene
from server.sim.section import Section
from server.sim.view import view


class Worlds:
    """Scenes, pybullet worlds and cameras by section; splits with equal sections share them. For use from one thread.

    Args:
        splits: by name.
        camera: what draws, one of `cameras.CAMERAS`.
    """

    def __init__(self, splits: Mapping[str, Split], camera: str = CAMERAS[0]) -> None:
        self._splits = splits
        first: dict[Section, tuple[str, str]] = {}
        self._first = {
            (split.name, id_): first.setdefault(section, (split.name, id_))
            for split in splits.values()
            for id_, section in split.sections.items()
        }
        """By split and section, the first split and section that is equal to it."""
        self._camera = camera
        self._scenes: dict[tuple[str, str], Scene] = {}
        self._grounds: dict[tuple[str, str], Obstacles] = {}
        self._cameras: dict[tuple[str, str] | None, Camera] = {}
        self._places: dict[tuple[str, str] | None, npt.NDArray[np.uint16]] = {}
        self._room: World | None = None

    def scene(self, split: str, section: str) -> Scene:
        """Return the scene of a section."""
        key = self._first[split, section]
        if key not in self._scenes:
            self._scenes[key] = city_scene(self._splits[key[0]].sections[key[1]])
        return self._scenes[key]

    def ground(self, split: str, section: str) -> Ground:
        """Return what answers the questions of the rules in a section."""
        key = self._first[split, section]
        if key not in self._grounds:
            # The reference camera needs a whole world. Otherwise colliders will do: 55 MB and 0.1 s less.
            self._grounds[key] = (World if self._camera == "tiny" else Obstacles)(self.scene(split, section))
        return self._grounds[key]

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
        """Draw what the agent sees in a state of an episode.

        Args:
            split: name of the episode's split.
            episode: that is played.
            state: of it.
            size: side length of the images, in pixels.
            segmentation: whether to label each pixel with its index in `server.sim.labels.LABELS`.
            into: arrays to draw into, as for `cameras.Camera.render`, but for the segmentation, which is always new.
        """
        seen = view(state, episode.layout)
        key = None if seen.indoors else self._first[split, episode.section]
        if key not in self._cameras:
            self._cameras[key] = self._made(key)
            self._places[key] = places_of(self._cameras[key].labels)
        frame = self._cameras[key].render(seen.viewpoint, seen.actors, size, segmentation=segmentation, into=into)
        if frame.segmentation is None:
            return frame
        return replace(frame, segmentation=self._places[key][frame.segmentation])

    def close(self) -> None:
        """Free all worlds."""
        for world in (*self._grounds.values(), self._room):
            if world is not None:
                world.close()
        self._grounds.clear()
        self._cameras.clear()
        self._room = None

    def _made(self, key: tuple[str, str] | None) -> Camera:
        """Make the camera of a section, or of the room."""
        if self._camera == "raster":
            return RasterCamera(room_scene() if key is None else self.scene(*key))
        if key is not None:
            ground = self.ground(*key)
            assert isinstance(ground, World)
            return ground
        self._room = World(room_scene())
        return self._room
