"""What there is to see in a state: which scene, from where, and with which objects in it."""

from dataclasses import dataclass
from functools import lru_cache

from server.sim.cameras import Actor, Viewpoint
from server.sim.collectibles import height_of
from server.sim.geometry import Pose
from server.sim.room import CELL, OBJECT_SCALE
from server.sim.rules import Collectible, Layout, Phase, PlacedObject, State

KEPT = 4096
"""Streets and rooms whose actors are kept, as they stay the same from step to step."""


@dataclass(frozen=True, slots=True)
class View:
    """What a camera needs for one frame, but for the scene.

    Attributes:
        indoors: whether the scene is the room; otherwise it is the episode's section.
        viewpoint: of the agent's eye.
        actors: the episode's own objects.
    """

    indoors: bool
    viewpoint: Viewpoint
    actors: tuple[Actor, ...]


def view(state: State, layout: Layout) -> View:
    """What the agent sees in `state`. The object it carries is not in view, as in the original."""
    if state.phase is Phase.ASSEMBLY:
        viewpoint = Viewpoint(state.square.column * CELL, state.square.row * CELL, state.room_heading)
        # An agent may stand where objects are; it looks over them rather than at their insides.
        around = tuple(item for item in state.room if (item.placement.column, item.placement.row) != state.square)
        return View(indoors=True, viewpoint=viewpoint, actors=room_actors(around))
    viewpoint = Viewpoint(state.pose.x, state.pose.z, state.pose.heading)
    return View(indoors=False, viewpoint=viewpoint, actors=street_actors(layout.streets[state.turn - 1]))


def visible_pose(state: State) -> Pose:
    """The agent's pose in the place where it is: in the room x and z are column and row."""
    if state.phase is Phase.ASSEMBLY:
        return Pose(state.square.column, state.square.row, state.room_heading)
    return state.pose


def street_actor(item: Collectible) -> Actor:
    """A collectible on the ground, turned some way that depends on where it stands."""
    return Actor(item.type, (item.position.x, item.position.z, 0.0), heading=(item.position.x * 97.0) % 360.0)


@lru_cache(KEPT)
def street_actors(street: tuple[Collectible, ...]) -> tuple[Actor, ...]:
    """All that stands in the street in a turn."""
    return tuple(map(street_actor, street))


@lru_cache(KEPT)
def room_actors(room: tuple[PlacedObject, ...]) -> tuple[Actor, ...]:
    """The room's objects, each on top of those that were placed on its cell before."""
    heights: dict[tuple[int, int], float] = {}
    actors = []
    for item in room:
        cell = (item.placement.column, item.placement.row)
        base = heights.get(cell, 0.0)
        heights[cell] = base + OBJECT_SCALE * height_of(item.type.kind)
        actors.append(Actor(item.type, (cell[0] * CELL, cell[1] * CELL, base), scale=OBJECT_SCALE))
    return tuple(actors)
