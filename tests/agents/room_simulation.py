"""Simulation of one assembly phase with the server's rules and camera, without a server."""

from dataclasses import replace
from functools import cache

import numpy as np

from arramon_agents.mapping.room_memory import RoomMemory
from arramon_agents.mapping.room_player import RoomPlayer
from arramon_client.agent import Label, Observation
from arramon_client.world import Action
from arramon_lang.meaning import Assembly
from arramon_server.sim.catalogue import ObjectType
from arramon_server.sim.geometry import Pose
from arramon_server.sim.labels import LABELS, places_of
from arramon_server.sim.raster.camera import RasterCamera
from arramon_server.sim.room import RoomPosition
from arramon_server.sim.room_scene import room_scene
from arramon_server.sim.rules import EpisodeLayout, Limits, Phase, Placed, PlacedObject, State, step
from arramon_server.sim.view import view

CLIENT_LABELS = tuple(Label(label.kind, label.colour, label.look) for label in LABELS)
HERE = Pose(0.0, 0.0, 0.0)


class Open:
    """Ground with nothing on it: in the room nobody asks it."""

    def way_is_free(self, start: tuple[float, float], end: tuple[float, float]) -> bool:
        return True


def things(*lines: str) -> tuple[PlacedObject, ...]:
    """Objects from lines such as "dotted red mug 1 1 2": type, then column, level, row."""
    found = []
    for line in lines:
        *name, column, level, row = line.split()
        found.append(PlacedObject(ObjectType.parse(" ".join(name)), RoomPosition(int(column), int(level), int(row))))
    return tuple(found)


def begin(room: tuple[PlacedObject, ...], carried: ObjectType) -> State:
    return State(HERE, room, phase=Phase.ASSEMBLY, carried=carried)


def observe(state: State, *, steps_left: int = 150, size: int = 128) -> Observation:
    seen = view(state, EpisodeLayout(HERE, ((), ()), ()))
    frame = camera().render(seen.viewpoint, seen.actors, size, segmentation=True)
    assert frame.segmentation is not None
    segmentation = places_of(camera().labels)[frame.segmentation]
    depth = (frame.depth / 1000).astype(np.float32)
    nothing_yet = Observation("1", 1, "assembly", 0, "Place it.", state.phase_step, steps_left - state.phase_step)
    return replace(nothing_yet, depth=depth, segmentation=segmentation)


def play(
    meaning: Assembly, room: tuple[PlacedObject, ...], carried: ObjectType, *, steps: int = 150, size: int = 128
) -> tuple[RoomPosition, bool, int]:
    """Where the follower puts the object, whether the step limit forced it, and after how many steps."""
    follower, state, layout = (
        RoomPlayer(meaning, RoomMemory(CLIENT_LABELS)),
        begin(room, carried),
        EpisodeLayout(HERE, ((), ()), ()),
    )
    for taken in range(1, steps + 1):
        action = Action(follower.act(observe(state, steps_left=steps, size=size)))
        state, events = step(state, action, layout, Open(), Limits(steps))
        for event in events:
            if isinstance(event, Placed):
                return event.placement, action is not Action.INTERACT, taken
    raise AssertionError("the rules end a phase at its step limit")


@cache
def camera() -> RasterCamera:
    return RasterCamera(room_scene())
