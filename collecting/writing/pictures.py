"""Pictures of what a writer sees: an agent's view by the server's camera, with the guide and the outlined target."""

from collections import OrderedDict
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from threading import Lock

import numpy as np
import numpy.typing as npt

from arramon_collecting.writing.guide import guide_of, with_guide
from arramon_collecting.writing.walk import Position, state_at
from arramon_server.episodes.episode import Episode
from arramon_server.episodes.splits import Split
from arramon_server.sim.cameras import CAMERAS, Camera
from arramon_server.sim.city import city_scene, refurnished
from arramon_server.sim.loaded_scene import LoadedScene
from arramon_server.sim.own_furniture import furnished
from arramon_server.sim.room import RoomCell
from arramon_server.sim.room_scene import room_scene
from arramon_server.sim.rules import PlacedObject
from arramon_server.sim.scene import Scene
from arramon_server.sim.section import Prop
from arramon_server.sim.view import View, room_actors, view

CACHED_SECTIONS = 8
"""Number of sections whose scenes and cameras are kept, about 12 MB each."""

CACHED_STREETS = 64
"""Number of cached streets with their guide: one for each turn that is being written about."""

EDGE_SHARE = 1 / 150
"""Width of the outline's edge, as a share of the picture's side."""

SHADE = 0.45
"""Brightness of what is seen through the outlined object."""

Pixels = npt.NDArray[np.uint8]
"""(size, size, 3) uint8."""


class WriterPictures:
    """Draws what writers see. Thread-safe if the camera is, otherwise for one thread.

    Args:
        splits: splits by name.
        camera: camera of the server's runs, one of `cameras.CAMERAS`.
    """

    def __init__(self, splits: Mapping[str, Split], camera: str = CAMERAS[0]) -> None:
        self._splits = splits
        self._camera_name = camera
        self._room = LoadedScene(room_scene, camera)
        self._sections = OrderedDict[tuple[str, str], LoadedScene]()
        self._streets = OrderedDict[tuple[str, str, int], tuple[Episode, Camera]]()
        self._lock = Lock()

    @property
    def draws_in_threads(self) -> bool:
        """Whether several threads may draw at once."""
        return self._camera_name == CAMERAS[0]

    def draw(self, split: str, episode: Episode, position: Position, size: int) -> Pixels:
        """Return the view at a position, (size, size, 3).

        Args:
            split: name of the episode's split.
            episode: the episode.
            position: where the writer is.
            size: side length, in pixels.
        """
        seen = view(state_at(position, episode), episode.layout)
        if position.is_indoors:
            with self._lock:
                camera = self._room.camera
            if position.is_placed:
                return camera.render(seen.viewpoint, seen.actors, size).rgb
            return _outlined(camera, seen, episode, position, size)
        return self._street(split, episode, position.turn).render(seen.viewpoint, seen.actors, size).rgb

    def close(self) -> None:
        """Free all scenes."""
        with self._lock:
            for scene in (self._room, *self._sections.values()):
                scene.close()
            self._sections.clear()
            self._streets.clear()

    def _street(self, split: str, episode: Episode, turn: int) -> Camera:
        """Return the camera of an episode's street with the guide of a turn."""
        key = split, episode.episode_id, turn
        with self._lock:
            episode_then, camera = self._streets.pop(key, (None, None))
            if camera is None or episode_then is not episode:
                camera = self._new_street(split, episode, turn)
            self._streets[key] = episode, camera
            if len(self._streets) > CACHED_STREETS:
                self._streets.popitem(last=False)
            return camera

    def _new_street(self, split: str, episode: Episode, turn: int) -> Camera:
        loaded = self._section(split, episode.section)
        scene = loaded.scene
        if not episode.furniture.is_empty:
            scene = refurnished(scene, furnished(self._splits[split].sections[episode.section], episode.furniture))
        guided = replace(scene, bodies=(*scene.bodies, *guide_of(episode.turns[turn - 1])))
        return loaded.camera.showing(guided)

    def _section(self, split: str, section: str) -> LoadedScene:
        key = split, section
        loaded = self._sections.pop(key, None)
        if loaded is None:
            loaded = LoadedScene(partial(_guided_section, self._splits[split], section), self._camera_name)
        self._sections[key] = loaded
        if len(self._sections) > CACHED_SECTIONS:
            (old, _), scene = self._sections.popitem(last=False)
            for street in [street for street in self._streets if street[0] == old]:
                del self._streets[street]
            scene.close()
        return loaded


def _guided_section(split: Split, section: str) -> Scene:
    """Return a section's scene with the looks of the guide and of all furniture that its episodes add."""
    looks: dict[tuple[str, str, str, str], Prop] = {}
    for episode in split.episodes.values():
        if episode.section == section:
            for prop in episode.furniture.added:
                looks.setdefault((prop.kind, prop.colour, prop.shape, prop.shape_colour), prop)
    return with_guide(city_scene(split.sections[section], [looks[look] for look in sorted(looks)]))


def _outlined(camera: Camera, seen: View, episode: Episode, position: Position, size: int) -> Pixels:
    """Return the view of the room with the carried object's outline, transparent black, where it belongs."""
    turn = episode.turns[position.turn - 1]
    goal = turn.target_cell
    plain = camera.render(seen.viewpoint, seen.actors, size)
    if RoomCell(goal.column, goal.row) == position.cell:  # The writer stands in it, as in any pile there.
        return plain.rgb
    state = state_at(position, episode)
    with_object = camera.render(
        seen.viewpoint, room_actors((*_around(state.room, position), PlacedObject(turn.target.type, goal))), size
    )
    shape = with_object.depth != plain.depth
    width = max(1, round(size * EDGE_SHARE))
    inside = shape.copy()
    for axis in (0, 1):
        for shift in range(-width, width + 1):
            inside &= np.roll(shape, shift, axis)
    shaded = plain.rgb.copy()
    shaded[shape] = np.rint(shaded[shape] * SHADE).astype(np.uint8)
    shaded[shape & ~inside] = 0
    return shaded


def _around(room: tuple[PlacedObject, ...], position: Position) -> tuple[PlacedObject, ...]:
    """Return the objects that are not on the writer's own cell, as in `sim.view.view`."""
    return tuple(item for item in room if (item.placement.column, item.placement.row) != position.cell)
