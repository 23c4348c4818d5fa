"""Aids that a host gives: what they say in each state, that they change no play, and where they are recorded."""

import asyncio
from collections.abc import Iterator
from contextlib import closing
from typing import Any

import numpy as np
import pytest
import simplejpeg

from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.journal import Journal
from arramon_server.sim.cameras import Frame
from arramon_server.sim.catalogue import ObjectType
from arramon_server.sim.geometry import Pose
from arramon_server.sim.labels import LABELS, SegmentationLabel
from arramon_server.sim.room import RoomCell
from arramon_server.sim.rules import Phase, State
from arramon_server.web.named_things import thing_name
from arramon_server.web.page_texts import all_texts
from arramon_server.web.play.aids import Aids
from arramon_server.web.play.person_state import cell_ahead
from arramon_server.web.play.play_page import names_of
from arramon_server.web.play.scene_words import VisibleThing, visible_things
from arramon_server.web.play.thing_pictures import ThingPictures, pictured_things
from tests import tiny
from tests.web.play.page_client import PageServer, page

F, L = tiny.F, tiny.L
ALL = ("--play-look-around", "--play-zoom", "--play-pictured-names", "--play-ahead", "--play-scene-words")


@pytest.fixture(scope="module")
def aided(tmp_path_factory: pytest.TempPathFactory) -> Iterator[PageServer]:
    server = PageServer(tmp_path_factory.mktemp("data"), *ALL)
    yield server
    assert server.stop() == 0


def test_new_aids_are_recorded_only_where_they_are_on() -> None:
    plain = [("landing_diagram", "off"), ("frame_strip", "off"), ("compass", "off")]
    assert Aids().as_arguments() == plain
    assert Aids(zoom=True).as_arguments() == [*plain, ("zoom", "on")]
    words = Aids(zoom=True, scene_words=True)
    assert (Aids(ahead=True).sensors, words.sensors) == (("rgb",), ("rgb", "depth", "segmentation"))
    assert words.offered_with(("rgb", "depth")) == Aids(zoom=True)
    assert words.offered_with(("rgb", "depth", "segmentation", "pose")) == words


def test_aids_say_what_is_ahead_in_every_state(aided: PageServer) -> None:
    async def play() -> list[dict[str, Any]]:
        async with page(aided.site) as client:
            await client.hello()
            return [message for message in await client.play() if message["type"] == "state"]

    states = asyncio.run(play())
    nothing, mug = {"in_reach": False, "object": ""}, {"in_reach": True, "object": "striped red mug"}
    tv = {"in_reach": True, "object": "dotted blue TV"}
    assert [state["ahead"] for state in states] == [
        nothing, mug, mug, {"cell": [2, 1], "objects": []}, {"cell": [2, 2], "objects": []},
        nothing, nothing, nothing, nothing, tv, tv,
        {"cell": [2, 1], "objects": []}, {"cell": [2, 2], "objects": ["striped red mug"]},
    ]  # fmt: skip
    seen = {(thing["side"], thing["name"], thing["steps"]) for thing in states[0]["scene"]}
    assert ("ahead", "striped red mug", 3) in seen
    assert any(name == "brick building" for _, name, _ in seen)


@pytest.mark.parametrize(
    ("square", "heading", "expected"),
    [
        (RoomCell(2, 0), 30.0, {"cell": None, "why": "oblique"}),
        (RoomCell(2, 0), 180.0, {"cell": None, "why": "wall"}),
        (RoomCell(2, 0), 270.0, {"cell": [1, 0], "objects": []}),
        (RoomCell(1, 0), 270.0, {"cell": [0, 0], "objects": ["dotted white bowl"]}),
    ],
)
def test_the_cell_ahead(square: RoomCell, heading: float, expected: dict[str, Any]) -> None:
    room = tiny.episode("0").decoys
    state = State(Pose(0.0, 0.0, 0.0), room, phase=Phase.ASSEMBLY, square=square, room_heading=heading)
    assert cell_ahead(state, str) == expected


def test_looking_around_changes_nothing(aided: PageServer) -> None:
    async def play() -> str:
        async with page(aided.site) as client:
            await client.hello(size=224)
            run = (await client.until("opened"))["run"]
            state = await client.until("state")
            left = simplejpeg.decode_jpeg(await client.look(state, 330))
            ahead = simplejpeg.decode_jpeg(await client.look(state, 0))
            await client.key(state, L)
            turned = await client.until("state")
            assert (turned["step"], turned["steps_left"]) == (1, state["steps_left"] - 1)
            same = simplejpeg.decode_jpeg(await client.look(turned, 0))
            assert np.array_equal(left, same)
            assert not np.array_equal(ahead, same)
            await client.say(type="look", episode=state["episode"], step=0, degrees=30)
            problem = await client.message()
            assert (problem["code"], "expected step 1" in problem["message"]) == ("Conflict", True)
            await client.say(type="look", episode="forged", step=1, degrees=30)
            assert "of 'forged' was requested" in (await client.message())["message"]
            return str(run)

    run = asyncio.run(play())
    with closing(Database(f"sqlite:///{aided.data / 'journal.db'}")) as database:
        journal = Journal(database)
        taken = [journal.actions(run, episode) for episode in journal.episode_ids(run)]
    assert taken == [[L]]


def test_looking_around_is_refused_without_the_aid(server: PageServer) -> None:
    async def play() -> None:
        async with page(server.site) as client:
            await client.hello()
            state = await client.until("state")
            assert not {"ahead", "scene"} & set(state)
            await client.say(type="look", episode=state["episode"], step=0, degrees=30)
            assert (await client.message())["message"] == "this run has no aid `look_around`"

    asyncio.run(play())


def test_hidden_splits_name_nothing(aided: PageServer) -> None:
    async def play() -> None:
        async with page(aided.site) as client:
            await client.hello(split="secret", episodes=0)
            opened = await client.until("opened")
            assert (opened["aids"]["ahead"], opened["aids"]["scene_words"]) == (True, False)
            state = await client.until("state")
            await client.key(state, F)
            state = await client.until("state")
            assert state["ahead"] == {"in_reach": True, "object": ""}
            assert "scene" not in state

    asyncio.run(play())


def test_visible_things_are_sorted_by_side_and_distance() -> None:
    mug, bench = LABELS.index(SegmentationLabel("mug", "red", "striped")), LABELS.index(SegmentationLabel("bench"))
    segmentation, depth = np.zeros((448, 448), np.uint16), np.full((448, 448), 9000, np.uint16)
    segmentation[200:240, 0:40], depth[200:240, 0:40] = bench, 4100
    segmentation[100:140, 60:100], depth[100:140, 60:100] = mug, 1400
    segmentation[200:300, 400:440] = mug
    segmentation[0:4, 200:204] = bench  # too small
    found = visible_things(Frame(np.zeros((448, 448, 3), np.uint8), depth, segmentation), is_room=False)
    assert found == [
        VisibleThing("left", LABELS[mug], 1),
        VisibleThing("left", LABELS[bench], 4),
        VisibleThing("right", LABELS[mug], 9),
    ]
    steps = [
        thing.steps
        for thing in visible_things(Frame(np.zeros((448, 448, 3), np.uint8), depth, segmentation), is_room=True)
    ]
    assert steps == [1, 3, 6]


NAMES = (
    (SegmentationLabel.of(ObjectType("dotted", "blue", "tv")), "dotted blue TV", "बिंदीदार नीला टीवी"),
    (SegmentationLabel.of(ObjectType("striped", "yellow", "ball")), "striped yellow ball", "धारीदार पीली गेंद"),
    (SegmentationLabel("car", "blue"), "blue parked car", "नीली कार"),
    (SegmentationLabel("building", look="brick"), "brick building", "ईंट की इमारत"),
    (SegmentationLabel("wall", look="wood"), "wooden wall", "लकड़ी की दीवार"),
    (SegmentationLabel("cone", "orange"), "orange cone", "नारंगी कोन"),
    (SegmentationLabel("banner", "red", "star"), "red banner: star", ""),
    (SegmentationLabel("road"), "", ""),
)


@pytest.mark.parametrize(("label", "english", "hindi"), NAMES)
def test_names(label: SegmentationLabel, english: str, hindi: str) -> None:
    assert thing_name(all_texts()["en"], label) == english
    if hindi:
        assert thing_name(all_texts()["hi"], label) == hindi


def test_every_label_that_people_can_name_has_a_name() -> None:
    for t in all_texts().values():
        unnamed = {label.kind for label in LABELS if not thing_name(t, label)}
        assert unnamed == {"nothing", "road", "pavement", "roof", "floor", "start_tile", "ceiling"}


def test_every_picture_shows_its_thing_and_has_names() -> None:
    pictures = ThingPictures("tiny")
    assert len(pictured_things()) == 45
    for thing in pictured_things():
        assert [code for code, name in names_of(thing) if name] == ["en", "hi"], thing
    for thing in ("mug", "hydrant", "banner", "building_red", "wall_brick"):
        picture = simplejpeg.decode_jpeg(pictures.jpeg(thing))
        assert 16 <= picture.shape[0] == picture.shape[1] < 224
        red, green, blue = picture.reshape(-1, 3).astype(int).mean(axis=0)
        assert {"banner": blue > red, "mug": True}.get(thing, red > blue + 5), (thing, red, green, blue)
