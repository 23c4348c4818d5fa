"""What can be seen of the room from its start tile, by the camera's segmentation, in the language's terms."""

import threading
from functools import cache

import numpy as np

from lang.placing import Room, Standing
from server.sim.cameras import Camera, Viewpoint
from server.sim.raster import RasterCamera
from server.sim.room import CELL, START
from server.sim.room_scene import room_scene
from server.sim.rules import PlacedObject
from server.sim.view import room_actors

SIZE = 128
"""Pixels of a frame's side."""

TURN = 30
"""Degrees between two frames: the agent's own turns."""

ENOUGH = 50
"""Pixels that a thing must have in one frame at least to be mentioned; one in the farthest corner that nothing hides
has twice as many."""


def whole_room(room: tuple[PlacedObject, ...]) -> Room:
    """All that stands in the room, hidden or not."""
    return Room(tuple(standing(item) for item in room), _walls())


def seen_room(room: tuple[PlacedObject, ...]) -> Room:
    """What of it an agent sees well that turns round on the start tile.

    Of two things of the very same type both are taken for seen if either is.
    """
    camera = _camera(threading.get_ident())
    actors = room_actors(room)
    most = np.zeros(len(camera.labels), dtype=np.int64)
    for heading in range(0, 360, TURN):
        viewpoint = Viewpoint(START.column * CELL, START.row * CELL, float(heading))
        segmentation = camera.render(viewpoint, actors, SIZE, segmentation=True).segmentation
        assert segmentation is not None  # it was asked for
        most = np.maximum(most, np.bincount(segmentation.ravel(), minlength=len(most)))
    seen = {label for label, pixels in zip(camera.labels, most.tolist(), strict=True) if pixels >= ENOUGH}
    return Room(tuple(standing(item) for item in room if str(item.type) in seen), _walls())


def standing(item: PlacedObject) -> Standing:
    """An object of the room in the language's terms."""
    type_, place = item.type, item.placement
    return Standing(type_.kind, type_.colour, type_.pattern, place.column, place.row, place.level)


@cache
def _camera(thread: int) -> Camera:  # noqa: ARG001 - a camera belongs to one thread
    return RasterCamera(room_scene())


@cache
def _walls() -> dict[str, int]:
    """In which quarter, clockwise from +row, the wall of each look stands."""
    labels = {body.label: body.heading for body in room_scene().bodies}
    walls = {label.split("/")[2]: heading for label, heading in labels.items() if label.startswith("wall/")}
    return {look: round(heading / 90.0) % 4 for look, heading in walls.items()}
