"""Worlds: created once per section, also for sections in several splits; episodes' own furniture in them."""

from contextlib import closing
from dataclasses import replace
from random import Random

import numpy as np
import pytest

from arramon_server.episodes.splits import Split
from arramon_server.runs.play.worlds import Worlds
from arramon_server.sim import loaded_scene, section_world
from arramon_server.sim.city import city_scene
from arramon_server.sim.geometry import Pose
from arramon_server.sim.own_furniture import NO_FURNITURE, MovedProp, OwnFurniture, furnished
from arramon_server.sim.physics import physics_of
from arramon_server.sim.raster.camera import RasterCamera
from arramon_server.sim.rules import Phase, begin
from arramon_server.sim.section import Prop
from tests import tiny
from tests.physics import EACH_CAMERA

OTHER = replace(tiny.SECTION, heading=45.0)


def split(name: str, section: str, world: str = "1") -> Split:
    episodes = {"0": replace(tiny.episode("0"), section=section)}
    sections = {section: replace(tiny.SECTION if world == "1" else OTHER, id=section)}
    return Split(name, False, "tests", episodes, sections, name)


def test_splits_with_the_same_section_share_it() -> None:
    one, two = split("one", "1"), split("two", "1")
    with closing(Worlds({"one": one, "two": two})) as worlds:
        assert worlds.world("one", one.episodes["0"]).scene is worlds.world("two", two.episodes["0"]).scene


def test_different_sections_of_one_name_stay_separate() -> None:
    one, two = split("one", "1"), split("two", "1", "2")
    with closing(Worlds({"one": one, "two": two})) as worlds:
        both = [worlds.world(each.name, each.episodes["0"]) for each in (one, two)]
        assert both[0].scene is not both[1].scene
        first, second = (world.render(begin(tiny.episode("0").layout), 32).rgb for world in both)
    assert not np.array_equal(first, second)


CONE, BENCH, BANNER = (
    Prop("cone", 0.0, 4.0, 0.0, "orange"),
    Prop("bench", 3.0, 6.0, 180.0),
    Prop("banner", -2.0, 11.0, 180.0, "red", "star", "white"),
)
FURNISHED = replace(tiny.SECTION, props=(CONE, BENCH, BANNER))
OWN = OwnFurniture(
    added=(
        Prop("barrel", 1.0, 5.0, 0.0, "gold"),
        Prop("barrel", -1.0, 5.0, 0.0, "gold"),
        Prop("barrel", 2.0, 8.0, 0.0, "red"),
        Prop("banner", 2.0, 11.0, 180.0, "black", "dot", "orange"),
    ),
    moved=(MovedProp(1, -3.0, 7.0, 150.0),),
    left_out=(0,),
)
OTHERS = OwnFurniture(added=(Prop("kiosk", 0.0, 6.0, 180.0, "green"),))


def own_split(name: str = "own") -> Split:
    own = {str(i): replace(tiny.episode(str(i)), furniture=each) for i, each in enumerate((OWN, OTHERS, NO_FURNITURE))}
    return Split(name, False, "tests", own, {"1": FURNISHED}, name)


VIEWS = [Pose(0.0, 0.0, 0.0), Pose(0.0, 2.0, 30.0), Pose(-4.0, 4.0, 60.0), Pose(3.0, 9.0, 210.0)]


@pytest.mark.parametrize("camera", EACH_CAMERA)
def test_an_episode_with_own_furniture_is_seen_as_a_section_of_its_own(camera: str) -> None:
    split = own_split()
    alone = {
        id_: Split(
            id_,
            False,
            "tests",
            {id_: replace(one, furniture=NO_FURNITURE)},
            {"1": furnished(FURNISHED, one.furniture)},
            id_,
        )
        for id_, one in split.episodes.items()
    }
    with closing(Worlds({"own": split}, camera)) as worlds, closing(Worlds(alone, camera)) as apart:
        for pose in VIEWS:
            for id_ in ("0", "2", "1", "0"):
                state = replace(begin(split.episodes[id_].layout), pose=pose)
                seen = worlds.world("own", split.episodes[id_]).render(state, 64, segmentation=True)
                expected = apart.world(id_, alone[id_].episodes[id_]).render(state, 64, segmentation=True)
                assert np.array_equal(seen.rgb, expected.rgb)
                assert np.array_equal(seen.depth, expected.depth)
                assert seen.segmentation is not None
                assert expected.segmentation is not None
                assert np.array_equal(seen.segmentation, expected.segmentation)


@pytest.mark.parametrize("camera", EACH_CAMERA)
def test_own_furniture_stands_in_the_way_of_its_episode_alone(camera: str) -> None:
    split = own_split()
    with closing(Worlds({"own": split}, camera)) as worlds:
        grounds = [worlds.world("own", split.episodes[id_]) for id_ in ("0", "1", "2")]
        for place, free in (
            ((1.0, 5.0), (False, True, True)),  # added
            ((0.0, 6.0), (True, False, True)),
            ((0.0, 4.0), (True, False, False)),  # left out
            ((3.0, 6.0), (True, False, False)),  # moved away
            ((-3.0, 7.0), (False, True, True)),  # moved there
            ((0.0, 11.5), (False, False, False)),  # the building
            ((9.0, 0.0), (True, True, True)),
        ):
            start = place[0] - 0.9, place[1]
            assert tuple(ground.way_is_free(start, place) for ground in grounds) == free, place


def test_ground_of_own_furniture_is_that_of_a_section_with_it() -> None:
    split, random = own_split(), Random(1)
    scene = city_scene(furnished(FURNISHED, OWN))
    with closing(Worlds({"own": split})) as worlds, closing(physics_of(scene)) as expected:
        ground, free = worlds.world("own", split.episodes["0"]), 0
        for _ in range(3000):
            x, z, angle = random.uniform(-5, 5), random.uniform(2, 11), random.uniform(0, 360)
            after = Pose(x, z, angle).ahead(1.0)
            move = (x, z), (after.x, after.z)
            assert ground.way_is_free(*move) == expected.way_is_free(*move), move
            free += ground.way_is_free(*move)
    assert 1000 < free < 2900


def test_scene_of_own_furniture_has_all_of_it_and_shares_the_rest() -> None:
    split = own_split()
    with closing(Worlds({"own": split})) as worlds:
        scenes = [worlds.world("own", split.episodes[id_]).scene for id_ in ("0", "2")]
        assert worlds.world("own", split.episodes["0"]).scene is scenes[0]
    names = [body.name for body in scenes[0].bodies]
    assert names[:7] == ["bench/0", "banner/0", "barrel/0", "barrel/1", "barrel/2", "banner/1", "building/0"]
    assert scenes[0].bodies[6:] == scenes[1].bodies[3:]
    assert scenes[0].meshes is scenes[1].meshes


def test_changed_furniture_of_an_episode_is_not_taken_from_the_cache() -> None:
    split = own_split()
    with closing(Worlds({"own": split})) as worlds:
        first = worlds.world("own", split.episodes["0"])
        assert worlds.world("own", replace(split.episodes["0"], furniture=OTHERS)).scene is not first.scene


@pytest.mark.parametrize("camera", EACH_CAMERA)
def test_rendering_only_draws_once_the_world_is_loaded(camera: str, monkeypatch: pytest.MonkeyPatch) -> None:
    split = own_split()
    with closing(Worlds({"own": split}, camera)) as worlds:
        for id_, episode in split.episodes.items():
            for _ in worlds.load("own", episode, drawn=True):
                pass
            with monkeypatch.context() as patch:
                for module, name in (
                    (section_world, "city_scene"),
                    (section_world, "refurnished"),
                    (loaded_scene, "RasterCamera"),
                    (loaded_scene, "reference_camera_of"),
                    (loaded_scene, "places_of"),
                ):
                    patch.setattr(module, name, None)
                patch.setattr(RasterCamera, "showing", None)
                world, state = worlds.world("own", split.episodes[id_]), begin(episode.layout)
                assert world.render(state, 32, segmentation=True).segmentation is not None
                room = replace(state, phase=Phase.ASSEMBLY)
                assert world.render(room, 32, segmentation=True).segmentation is not None


def test_without_frames_no_camera_is_built(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(loaded_scene, "RasterCamera", None)
    split = own_split()
    with closing(Worlds({"own": split})) as worlds:
        parts = list(worlds.load("own", split.episodes["0"], drawn=False))
        assert len(parts) == 2
        assert not worlds.world("own", split.episodes["0"]).way_is_free((0.1, 5.0), (1.0, 5.0))
