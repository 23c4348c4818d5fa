"""The room follower: placement by depth and segmentation alone."""

from dataclasses import replace

import numpy as np
import pytest

from arramon_agents.mapping.room_memory import RoomMemory
from arramon_agents.mapping.room_player import RoomPlayer
from arramon_client.agent import Observation
from arramon_lang.meaning import Assembly, Thing, Where
from arramon_server.sim.catalogue import ObjectType
from tests.agents.room_simulation import CLIENT_LABELS, begin, observe, play, things

ROOM = things(
    "dotted red mug 1 1 2",
    "striped blue tv 3 1 1",
    "dotted green bowl 3 2 1",
    "striped yellow book 4 1 3",
    "dotted white ball 0 1 0",
    "striped red mug 2 1 3",
)
BUCKET = ObjectType("striped", "purple", "bucket")


def told(relation: str, *landmarks: Thing, turns: tuple[str, ...] = (), exactly: bool = False) -> Assembly:
    return Assembly(turns, Thing("bucket"), (Where(relation, landmarks, exactly),))


@pytest.mark.parametrize(
    ("meaning", "placement"),
    [
        (told("on_top_of", Thing("book")), (4, 2, 3)),
        (told("on_top_of", Thing("bowl")), (3, 3, 1)),
        (told("on_top_of", Thing("tv")), (3, 3, 1)),
        (told("on_top_of", Thing("ball")), (0, 2, 0)),
        (told("left_of", Thing("mug", look="dotted")), (0, 1, 2)),
        (told("right_of", Thing("mug", look="dotted"), exactly=True), (2, 1, 2)),
        (told("behind", Thing("tv")), (3, 1, 2)),
        (told("in_front_of", Thing("book")), (4, 1, 2)),
        (told("right_of", Thing("tv"), turns=("right",)), (3, 1, 0)),
        (told("left_of", Thing("tv"), turns=("right",)), (3, 1, 2)),
        (told("in_front_of", Thing("you"), turns=("left",)), (1, 1, 0)),
        (told("in_front_of", Thing("you")), (2, 1, 1)),
        (told("between", Thing("mug", "red", "striped"), Thing("book")), (3, 1, 3)),
        (told("against", Thing("wall", look="wood"), turns=("right",)), (4, 1, 0)),
        (told("right_of", Thing("mug", where=(Where("against", (Thing("wall", look="brick"),)),))), (3, 1, 3)),
    ],
)
def test_the_object_is_placed_as_instructed(meaning: Assembly, placement: tuple[int, int, int]) -> None:
    assert play(meaning, ROOM, BUCKET)[:2] == (placement, False)


@pytest.mark.parametrize("size", [64, 224])
def test_frames_may_be_of_any_size(size: int) -> None:
    assert play(told("on_top_of", Thing("book")), ROOM, BUCKET, size=size)[0] == (4, 2, 3)


def test_a_second_look_finds_objects_hidden_from_the_start() -> None:
    room = things("striped blue tv 2 1 1", "dotted red bowl 2 1 3")
    placement, _, steps = play(told("on_top_of", Thing("bowl")), room, BUCKET)
    assert placement == (2, 2, 3)
    assert steps > 20


def test_relations_to_absent_objects_are_ignored() -> None:
    meaning = Assembly(
        (), Thing(""), (Where("near", (Thing("fountain"),)), Where("on_top_of", (Thing("book", "green"),)))
    )
    assert play(meaning, ROOM, BUCKET)[0] == (4, 2, 3)


@pytest.mark.parametrize("steps", [26, 30, 40])
def test_the_object_is_placed_before_the_steps_run_out(steps: int) -> None:
    assert not play(told("on_top_of", Thing("fountain")), ROOM, BUCKET, steps=steps)[1]


def test_cells_levels_and_walls_are_reconstructed() -> None:
    sight = RoomMemory(CLIENT_LABELS)
    for heading in (0.0, 30.0):
        seen = observe(replace(begin(ROOM, BUCKET), room_heading=heading))
        assert seen.depth is not None
        assert seen.segmentation is not None
        sight.add(seen.depth, seen.segmentation, (2, 0), heading)
    found = {(t.look, t.colour, t.kind): (t.column, t.level, t.row) for t in sight.room().things}
    assert found["striped", "blue", "tv"] == (3, 1, 1)
    assert found["dotted", "green", "bowl"] == (3, 2, 1)
    assert found["striped", "red", "mug"] == (2, 1, 3)
    assert ("dotted", "white", "ball") not in found
    assert sight.room().walls == {"brick": 0, "wood": 1}


def test_missing_sensors_are_named() -> None:
    meaning = told("on_top_of", Thing("book"))
    with pytest.raises(ValueError, match="no labels"):
        RoomPlayer(meaning, RoomMemory(()))
    bare = Observation("1", 1, "assembly", 0, "Place it.", 0, 150, rgb=np.zeros((8, 8, 3), np.uint8))
    with pytest.raises(ValueError, match="depth"):
        RoomPlayer(meaning, RoomMemory(CLIENT_LABELS)).act(bare)


@pytest.mark.parametrize(("kind", "is_object"), [("banner", False), ("cone", False), ("mug", True)])
def test_only_collectibles_are_objects(kind: str, is_object: bool) -> None:
    number = next(i for i, label in enumerate(CLIENT_LABELS) if label.kind == kind)
    sight = RoomMemory(CLIENT_LABELS)
    sight.add(np.full((8, 8), 3.0, np.float32), np.full((8, 8), number, np.uint16), (2, 0), 0.0)
    assert bool(sight.room().things) == is_object
