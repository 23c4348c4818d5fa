"""The agent's view in a state: scene, viewpoint and objects."""

from dataclasses import dataclass
from functools import lru_cache

from arramon_client.world import CELL_SIZE
from arramon_server.sim.assets.collectibles import height_of
from arramon_server.sim.cameras import Actor, Viewpoint
from arramon_server.sim.geometry import Pose
from arramon_server.sim.identity_cache import IdentityCache
from arramon_server.sim.room import OBJECT_SCALE
from arramon_server.sim.rules import Collectible, EpisodeLayout, Phase, PlacedObject, State

CACHED_POSES = 4096
"""Number of streets and rooms whose actors are cached, as they rarely change between steps."""


@dataclass(frozen=True, slots=True)
class View:
    """Input of a camera for one frame.

    Attributes:
        indoors: whether the scene is the room; otherwise it is the episode's section.
        viewpoint: viewpoint of the agent.
        actors: the episode's own objects.
    """

    indoors: bool
    viewpoint: Viewpoint
    actors: tuple[Actor, ...]


def view(state: State, layout: EpisodeLayout) -> View:
    """Return the agent's view in `state`. The object that it carries is not visible, as in the original."""
    if state.phase is Phase.ASSEMBLY:
        viewpoint = Viewpoint(state.square.column * CELL_SIZE, state.square.row * CELL_SIZE, state.room_heading)
        # An agent may stand on a cell with objects; these are left out, so that it does not see their insides.
        around = tuple(item for item in state.room if (item.placement.column, item.placement.row) != state.square)
        if len(around) == len(state.room):
            return View(indoors=True, viewpoint=viewpoint, actors=_actors_of_room(state.room))
        return View(indoors=True, viewpoint=viewpoint, actors=room_actors(around))
    viewpoint = Viewpoint(state.pose.x, state.pose.z, state.pose.heading)
    return View(indoors=False, viewpoint=viewpoint, actors=_actors_of_street(layout.streets[state.turn - 1]))


def visible_pose(state: State) -> Pose:
    """Return the agent's pose; in the room x and z are column and row."""
    if state.phase is Phase.ASSEMBLY:
        return Pose(state.square.column, state.square.row, state.room_heading)
    return state.pose


def street_actor(item: Collectible) -> Actor:
    """Return the actor of a collectible on the ground, with a heading derived from its position."""
    return Actor(item.type, (item.position.x, item.position.z, 0.0), heading=(item.position.x * 97.0) % 360.0)


@lru_cache(CACHED_POSES)
def street_actors(street: tuple[Collectible, ...]) -> tuple[Actor, ...]:
    """Return the actors of all objects in the street in a turn."""
    return tuple(map(street_actor, street))


@lru_cache(CACHED_POSES)
def room_actors(room: tuple[PlacedObject, ...]) -> tuple[Actor, ...]:
    """Return the actors of the room's objects, each on top of those placed earlier on its cell."""
    heights: dict[tuple[int, int], float] = {}
    actors = []
    for item in room:
        cell = (item.placement.column, item.placement.row)
        base = heights.get(cell, 0.0)
        heights[cell] = base + OBJECT_SCALE * height_of(item.type.kind)
        actors.append(Actor(item.type, (cell[0] * CELL_SIZE, cell[1] * CELL_SIZE, base), scale=OBJECT_SCALE))
    return tuple(actors)


_actors_of_street: IdentityCache[tuple[Collectible, ...], tuple[Actor, ...]] = IdentityCache(
    street_actors, CACHED_POSES
)
_actors_of_room: IdentityCache[tuple[PlacedObject, ...], tuple[Actor, ...]] = IdentityCache(room_actors, CACHED_POSES)
"""By identity: streets and rooms stay the same objects from step to step, and hashing them takes microseconds."""
