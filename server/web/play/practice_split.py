"""The tutorial's split: three short episodes in a street of their own, read from `practice.toml`."""

import hashlib
import tomllib
from importlib import resources
from typing import Any

from arramon_client.world import Action
from arramon_server.episodes.episode import Episode, Instructions, Turn
from arramon_server.episodes.splits import Split
from arramon_server.sim.catalogue import ObjectType
from arramon_server.sim.geometry import Point, Pose
from arramon_server.sim.room import START, RoomCell, RoomPosition
from arramon_server.sim.rules import Collectible, PlacedObject, moved
from arramon_server.sim.section import Building, Prop, Section

PRACTICE = "practice"
"""Name of the split."""

_ACTIONS = {"F": Action.FORWARD, "L": Action.LEFT, "R": Action.RIGHT, "P": Action.INTERACT}
_SECTION = "1"
_GROUND = 0.1
"""Height of an object's centre above the ground, in units."""


def practice_split() -> Split:
    """Return the tutorial's split; its episodes are in the order in which they are played."""
    content = resources.files("arramon_server.web.play").joinpath("practice.toml").read_bytes()
    data = tomllib.loads(content.decode())
    buildings = tuple(
        Building(x, z, half_width, half_length, 0.0, height, facade)
        for x, z, half_width, half_length, height, facade in data["section"]["buildings"]
    )
    props = tuple(Prop(*prop) for prop in data["section"]["props"])
    bounds: tuple[float, float, float, float] = tuple(data["section"]["bounds"])
    section = Section(_SECTION, 0.0, bounds, buildings, props)
    episodes = [_episode(described) for described in data["episode"]]
    return Split(
        PRACTICE,
        hidden=False,
        source="the tutorial",
        episodes={episode.episode_id: episode for episode in episodes},
        sections={_SECTION: section},
        data_hash=hashlib.sha256(content).hexdigest(),
        training=True,
    )


def _episode(described: dict[str, Any]) -> Episode:
    start = pose = Pose(*described["start"])
    turns: list[Turn] = []
    for turn in described["turn"]:
        path = [(pose.x, pose.z)]
        actions = tuple(_ACTIONS[letter] for letter in turn["actions"])
        for action in actions:
            pose = moved(pose, action)
            if action is Action.FORWARD:
                path.append((pose.x, pose.z))
        room_actions = tuple(_ACTIONS[letter] for letter in turn["room_actions"])
        street = tuple(
            Collectible(ObjectType(pattern, colour, kind), Point(x, _GROUND, z))
            for pattern, colour, kind, x, z in turn["objects"]
        )
        column, row = turn["cell"]
        cell = RoomPosition(column, 1, row)
        turns.append(Turn(tuple(path), actions, _room_path(room_actions), room_actions, street, cell))
    decoys = tuple(
        PlacedObject(ObjectType(pattern, colour, kind), RoomPosition(column, 1, row))
        for pattern, colour, kind, column, row in described["decoys"]
    )
    first, second = described["turn"]
    texts = {code: (Instructions(*first[code]), Instructions(*second[code])) for code in ("en", "hi")}
    return Episode(described["id"], _SECTION, start, (turns[0], turns[1]), decoys, texts)


def _room_path(actions: tuple[Action, ...]) -> tuple[RoomCell, ...]:
    cell, heading, path = START, 0.0, [START]
    for action in actions:
        if action is Action.FORWARD:
            cell = cell.ahead(heading)
            path.append(cell)
        else:
            heading += {Action.LEFT: -30.0, Action.RIGHT: 30.0}.get(action, 0.0)
    return tuple(path)
