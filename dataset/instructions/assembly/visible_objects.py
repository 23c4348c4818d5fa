"""The objects of the room that the camera shows from the start tile, as an `arramon_lang.cell_grading.Room`."""

import threading
from functools import cache, lru_cache

import numpy as np

from arramon_client.world import CELL_SIZE, TURN_DEGREES
from arramon_lang.cell_grading import Room, RoomObject
from arramon_server.sim.cameras import Camera, Viewpoint
from arramon_server.sim.raster.camera import RasterCamera
from arramon_server.sim.room import START
from arramon_server.sim.room_scene import room_scene
from arramon_server.sim.rules import PlacedObject
from arramon_server.sim.view import room_actors

SIZE = 128
"""Side length of a frame, in pixels."""

MIN_PIXELS = 50
"""Minimum number of pixels in one frame for an object to be mentioned; an unobstructed one in the farthest corner has
twice as many."""

CACHED = 8
"""Number of rooms whose visible part is cached: many instructions are drawn for each."""


def whole_room(room: tuple[PlacedObject, ...]) -> Room:
    """Return all objects in the room, visible or not."""
    return Room(tuple(to_room_object(item) for item in room), _walls())


@lru_cache(maxsize=CACHED)
def visible_room(room: tuple[PlacedObject, ...]) -> Room:
    """Return the objects that an agent sees well when it turns around on the start tile.

    Of two objects of the same type, both are returned if either is seen.
    """
    camera = _camera(threading.get_ident())
    actors = room_actors(room)
    most = np.zeros(len(camera.labels), dtype=np.int64)
    for heading in range(0, 360, TURN_DEGREES):
        viewpoint = Viewpoint(START.column * CELL_SIZE, START.row * CELL_SIZE, float(heading))
        segmentation = camera.render(viewpoint, actors, SIZE, segmentation=True).segmentation
        assert segmentation is not None  # Requested above.
        most = np.maximum(most, np.bincount(segmentation.ravel(), minlength=len(most)))
    seen = {label for label, pixels in zip(camera.labels, most.tolist(), strict=True) if pixels >= MIN_PIXELS}
    return Room(tuple(to_room_object(item) for item in room if str(item.type) in seen), _walls())


def to_room_object(item: PlacedObject) -> RoomObject:
    """Convert an object of the simulated room to an `arramon_lang.cell_grading.RoomObject`."""
    type_, place = item.type, item.placement
    return RoomObject(type_.kind, type_.colour, type_.pattern, place.column, place.row, place.level)


@cache
def _camera(thread: int) -> Camera:  # noqa: ARG001 - cameras are not thread-safe
    return RasterCamera(room_scene())


@cache
def _walls() -> dict[str, int]:
    """Return, by look, the quarter of each wall, clockwise from +row."""
    labels = {body.label: body.heading for body in room_scene().bodies}
    walls = {label.split("/")[2]: heading for label, heading in labels.items() if label.startswith("wall/")}
    return {look: round(heading / 90.0) % 4 for look, heading in walls.items()}
