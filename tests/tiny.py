"""A tiny split: one wall, and episodes that all have the same ground truth."""

from pathlib import Path

from arramon_client.world import Action
from arramon_server.episodes.episode import Episode, Instructions, Turn
from arramon_server.episodes.splits import Split, write_split
from arramon_server.sim.catalogue import ObjectType
from arramon_server.sim.geometry import Point, Pose
from arramon_server.sim.room import RoomCell, RoomPosition
from arramon_server.sim.rules import Collectible, PlacedObject
from arramon_server.sim.section import Building, Section

F, L, R, P = Action.FORWARD, Action.LEFT, Action.RIGHT, Action.INTERACT

SECTION = Section("1", 0.0, (-20.0, -20.0, 20.0, 20.0), (Building(0.0, 12.0, 5.0, 1.0, 0.0, 3.0, "brick"),), ())

TARGETS = (ObjectType("striped", "red", "mug"), ObjectType("dotted", "blue", "tv"))

ACTIONS = (F, F, P, F, P, R, R, R, F, F, P, F, P)
"""The ground truth of both turns and phases, in order."""


def episode(episode_id: str, languages: tuple[str, ...] = ("en", "hi")) -> Episode:
    texts = {
        "en": Instructions("Go on to the striped red mug.", "Put it two steps ahead."),
        "hi": Instructions("धारीदार लाल मग तक चलें।", "उसे दो क़दम आगे रखें।"),
    }
    others = (Collectible(ObjectType("striped", "green", "mug"), Point(-6.0, 0.0, -6.0)),)
    turns = (
        Turn(
            path=((0.0, 0.0), (0.0, 1.0), (0.0, 2.0)),
            actions=(F, F, P),
            room_path=(RoomCell(2, 0), RoomCell(2, 1)),
            room_actions=(F, P),
            street=(Collectible(TARGETS[0], Point(0.0, 0.1, 3.5)), *others),
            target_cell=RoomPosition(2, 1, 2),
        ),
        Turn(
            path=((0.0, 2.0), (1.0, 2.0), (2.0, 2.0)),
            actions=(R, R, R, F, F, P),
            room_path=(RoomCell(2, 0), RoomCell(2, 1)),
            room_actions=(F, P),
            street=(Collectible(TARGETS[1], Point(3.5, 0.1, 2.0)), *others),
            target_cell=RoomPosition(2, 2, 2),
        ),
    )
    decoys = (PlacedObject(ObjectType("dotted", "white", "bowl"), RoomPosition(0, 1, 0)),)
    instructions = {code: (texts[code], texts[code]) for code in languages}
    return Episode(episode_id, "1", Pose(0.0, 0.0, 0.0), turns, decoys, instructions)


def write(data: Path, name: str = "tiny", count: int = 6, *, hidden: bool = False, training: bool = False) -> Split:
    """Writes the split into a data folder. Every third episode has no Hindi."""
    episodes = [episode(str(i), ("en",) if i % 3 == 0 else ("en", "hi")) for i in range(count)]
    return write_split(
        data, name, hidden=hidden, training=training, source="tests", episodes=episodes, sections=[SECTION]
    )
