"""Landmarks visible along a path."""

import pytest

from arramon_dataset.instructions.visible_landmarks import (
    find_landmarks,
    is_recognisable,
    poses_along,
    with_names_as_labels,
)
from arramon_dataset.plans.graph import Arm, Corner, Junction, StreetGraph
from arramon_dataset.plans.named_buildings import named_building
from arramon_server.sim.city import city_scene
from arramon_server.sim.geometry import Pose
from arramon_server.sim.raster.camera import RasterCamera
from arramon_server.sim.section import Prop
from tests.dataset.instructions.town import ACTIONS, PATH, START, STREET, F, L, crossing


def test_poses_follow_path_and_turns() -> None:
    poses = poses_along(START, PATH, ACTIONS)
    assert len(poses) == len(ACTIONS) + 1
    assert poses[0] == START
    assert poses[18] == Pose(0.0, 0.0, 90.0)
    assert poses[-1] == Pose(12.0, 0.0, 90.0)


@pytest.mark.parametrize("actions", [(F, F), (F, L), (F, F, F)])
def test_path_and_actions_must_have_equal_steps(actions: tuple[object, ...]) -> None:
    path = [(0.0, 0.0), (0.0, 1.0), (0.0, 2.0)]
    if actions == (F, F):
        assert len(poses_along(Pose(0.0, 0.0, 0.0), path, (F, F))) == 3
    else:
        with pytest.raises(ValueError, match="step forward"):
            poses_along(Pose(0.0, 0.0, 0.0), path, actions)  # type: ignore[arg-type]


def test_landmarks_behind_walls_are_not_seen() -> None:
    section = crossing(Prop("barrel", -15.0, 0.5, 0.0, colour="gold"))
    poses = poses_along(START, PATH, ACTIONS)
    landmarks = {
        mark.label.kind: mark
        for mark in find_landmarks(poses, STREET, section, RasterCamera(with_names_as_labels(city_scene(section))))
    }
    assert landmarks["phone_booth"].seen[0] == 0
    assert landmarks["kiosk"].seen[0] > 12  # round the corner
    assert landmarks["barrel"].seen == ()  # in the street that the path turns away from
    assert (landmarks["kiosk"].x, landmarks["kiosk"].z) == (9.0, -2.5)


def test_looking_around_reveals_landmarks_behind_the_start() -> None:
    section = crossing(Prop("bin", 0.5, -19.0, 0.0))
    landmarks = find_landmarks(
        poses_along(START, PATH, ACTIONS), STREET, section, RasterCamera(with_names_as_labels(city_scene(section)))
    )
    assert next(mark for mark in landmarks if mark.label.kind == "bin").seen == (-1,)


SECTION_GRAPH = StreetGraph(
    junctions=(
        Junction("junction/0", 0.0, 0.0, "crossing", tuple(Arm(h, "street/0", "", 0.0, 0.0) for h in (0.0, 90.0)), 3.0),
        Junction("junction/1", -20.0, 0.0, "street_end", (Arm(90.0, "street/0", "", -17.0, 0.0),), 3.0),
    ),
    roads=(),
    corners=(Corner("corner/0", 3.0, -3.0, "building/2", "junction/0"),),
    buildings=tuple(named_building(number, crossing(), (), ()) for number in range(len(crossing().buildings))),
)


def test_everything_has_the_identity_of_its_body() -> None:
    section = crossing(Prop("kiosk", 0.0, -19.0, 0.0, colour="red"))
    scene = city_scene(section)
    camera = RasterCamera(with_names_as_labels(scene))
    landmarks = find_landmarks(poses_along(START, PATH, ACTIONS), STREET, section, camera, SECTION_GRAPH)
    names = [mark.identity for mark in landmarks if mark.label.kind != "intersection"]
    assert len(set(names)) == len(names)
    bodies = {body.name: body for body in scene.bodies}
    for mark in landmarks:
        if mark.identity in bodies:
            assert bodies[mark.identity].label == str(mark.label)
        assert len(mark.pixels) == len(mark.seen)
    by_name = {mark.identity: mark for mark in landmarks}
    assert by_name["kiosk/1"].seen == (-1,)
    assert by_name["kiosk/0"].seen[0] > 12
    assert {mark.identity for mark in landmarks if mark.label.kind == "intersection"} == {"junction/0"}
    assert [f"collectible/{i}" in by_name for i in range(4)] == [True, True, True, False]


def test_buildings_junctions_and_corners_are_seen_where_no_wall_hides_them() -> None:
    section = crossing()
    camera = RasterCamera(with_names_as_labels(city_scene(section)))
    landmarks = find_landmarks(poses_along(START, PATH, ACTIONS), STREET, section, camera, SECTION_GRAPH)
    by_name = {mark.identity: mark for mark in landmarks if mark.label.kind != "intersection"}
    assert by_name["building/2"].seen[:3] == (-1, 0, 2)
    assert (by_name["building/2"].x, by_name["building/2"].z) == (3.0, -13.0)
    assert by_name["junction/0"].seen[0] == 0
    assert by_name["junction/1"].seen == ()
    assert by_name["corner/0"].seen[0] == 2  # 12 units away at 1, and every second pose is looked from
    assert by_name["corner/0"].seen[-1] < 18


@pytest.mark.parametrize(
    ("kind", "pixels", "rows", "recognised"),
    [
        ("hydrant", 90, 12, True),
        ("hydrant", 89, 12, False),
        ("bench", 200, 6, False),
        ("speed_sign", 120, 40, False),
        ("mug", 45, 6, True),
        ("zebra_crossing", 200, 3, True),
        ("building", 1199, 60, False),
    ],
)
def test_what_is_too_small_is_not_recognised(kind: str, pixels: int, rows: int, recognised: bool) -> None:
    assert is_recognisable(kind, pixels, rows) is recognised
