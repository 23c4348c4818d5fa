"""What is seen along a path."""

import pytest

from server.dataset.instructions.sight import find_landmarks, identified, poses_along
from server.sim.city import city_scene
from server.sim.geometry import Pose
from server.sim.raster.camera import RasterCamera
from server.sim.section import Prop
from tests.dataset.instructions.town import ACTIONS, PATH, START, STREET, F, L, crossing


def test_poses_follow_path_and_turns() -> None:
    poses = poses_along(START, PATH, ACTIONS)
    assert len(poses) == len(ACTIONS) + 1
    assert poses[0] == START
    assert poses[18] == Pose(0.0, 0.0, 90.0)
    assert poses[-1] == Pose(12.0, 0.0, 90.0)


@pytest.mark.parametrize("actions", [(F, F), (F, L), (F, F, F)])
def test_a_path_must_have_its_steps(actions: tuple[object, ...]) -> None:
    path = [(0.0, 0.0), (0.0, 1.0), (0.0, 2.0)]
    if actions == (F, F):
        assert len(poses_along(Pose(0.0, 0.0, 0.0), path, (F, F))) == 3
    else:
        with pytest.raises(ValueError, match="step forward"):
            poses_along(Pose(0.0, 0.0, 0.0), path, actions)  # type: ignore[arg-type]


def test_only_what_no_wall_hides_is_seen() -> None:
    section = crossing(Prop("barrel", -15.0, 0.5, 0.0, colour="gold"))
    poses = poses_along(START, PATH, ACTIONS)
    marks = {
        mark.label.kind: mark
        for mark in find_landmarks(poses, STREET, section, RasterCamera(identified(city_scene(section))))
    }
    assert marks["phone_booth"].seen[0] == 0
    assert marks["kiosk"].seen[0] > 12  # round the corner
    assert marks["barrel"].seen == ()  # in the street that the path turns away from
    assert (marks["kiosk"].x, marks["kiosk"].z) == (9.0, -2.5)


def test_a_look_round_shows_what_is_behind_the_start() -> None:
    section = crossing(Prop("bin", 0.5, -19.0, 0.0))
    marks = find_landmarks(
        poses_along(START, PATH, ACTIONS), STREET, section, RasterCamera(identified(city_scene(section)))
    )
    assert next(mark for mark in marks if mark.label.kind == "bin").seen == (-1,)
