"""Navigation plans: turns, names of landmarks, and the description of the target."""

from dataclasses import replace

import pytest

from arramon_client.world import bearing, turn_between
from arramon_dataset.instructions.navigation.landmark_names import unique_name
from arramon_dataset.instructions.navigation.plan import is_doubled, plan_navigation
from arramon_dataset.instructions.navigation.target import describe_target
from arramon_dataset.instructions.visible_landmarks import Landmark, find_landmarks, poses_along, with_names_as_labels
from arramon_dataset.randomness import seeded
from arramon_lang.coreference import things_of
from arramon_lang.meaning import Face, Navigation, Rotate, Step, Thing, Walk
from arramon_server.sim.city import city_scene
from arramon_server.sim.geometry import Pose
from arramon_server.sim.labels import SegmentationLabel
from arramon_server.sim.raster.camera import RasterCamera
from tests.dataset.instructions.town import ACTIONS, PATH, START, STREET, R, crossing, thing

SECTION = crossing()


@pytest.fixture(scope="module")
def camera() -> RasterCamera:
    return RasterCamera(with_names_as_labels(city_scene(SECTION)))


def plan(camera: RasterCamera, attempt: int) -> Navigation | None:
    poses = poses_along(START, PATH, ACTIONS)
    landmarks = find_landmarks(poses, STREET, SECTION, camera)
    return plan_navigation(PATH, poses, STREET[0], STREET, landmarks, seeded("plan", attempt))


def test_plan_turns_right_at_the_crossing(camera: RasterCamera) -> None:
    for attempt in range(10):
        made = plan(camera, attempt)
        assert made is not None
        turns = [step for step in made.steps if isinstance(step, Rotate)]
        assert [turn.direction for turn in turns] == ["right"]
        assert (made.target.kind, made.target.colour, made.target.look)[0] == "mug"


def test_a_second_turn_often_begins_with_a_landmark_to_face(camera: RasterCamera) -> None:
    start, actions = START.turned(180.0), (R,) * 6 + ACTIONS
    poses = poses_along(start, PATH, actions)
    landmarks = find_landmarks(poses, STREET, SECTION, camera)
    places = {landmark.identity: (landmark.x, landmark.z) for landmark in landmarks}
    faced = []
    for attempt in range(30):
        made = plan_navigation(PATH, poses, STREET[0], STREET, landmarks, seeded(attempt), is_first=False)
        assert made is not None
        after = [(step.thing, made.steps[at + 1]) for at, step in enumerate(made.steps) if isinstance(step, Face)]
        faced += [(thing, thing in things_of(step)) for thing, step in after]
    assert all(abs(turn_between(0.0, bearing(PATH[0], places[thing.identity]))) <= 40.0 for thing, _ in faced)
    assert 8 <= len(faced) < 30
    assert {is_named for _, is_named in faced} == {False, True}


def test_plans_vary_with_the_seed_and_are_reproducible(camera: RasterCamera) -> None:
    made = [plan(camera, attempt) for attempt in range(12)]
    assert len({repr(one) for one in made}) >= 4
    assert plan(camera, 3) == made[3]


@pytest.mark.parametrize(
    ("last", "step", "expected"),
    [
        (Walk("ahead"), Walk("along", (Thing("street"),)), True),
        (Walk("towards", (Thing("bench"),)), Walk("to", (Thing("bench"),)), True),
        (Walk("to", (Thing("bench"),)), Walk("until", (Thing("bench"),)), True),
        (Walk("until", (Thing("bench"),)), Walk("to", (Thing("bench"),)), False),  # "Until you see a bench. Go to it."
        (Walk("towards", (Thing("bench"),)), Walk("past", (Thing("bench"),)), False),
        (Walk("towards", (Thing("bench"),)), Walk("to", (Thing("cone"),)), False),
        (Walk("ahead"), Rotate("left"), False),
    ],
)
def test_a_step_that_repeats_the_one_before_is_doubled(last: Step, step: Step, expected: bool) -> None:
    assert is_doubled((last,), step) is expected
    assert not is_doubled((), step)


def test_target_unseen_at_the_end_gives_no_plan(camera: RasterCamera) -> None:
    hidden = thing("striped red mug", -20.0, 0.0)
    street = (hidden, *STREET[1:])
    poses = poses_along(START, PATH, ACTIONS)
    landmarks = find_landmarks(poses, street, SECTION, camera)
    assert plan_navigation(PATH, poses, hidden, street, landmarks, seeded("x")) is None


def mark(kind: str, x: float, z: float, *seen: int, colour: str = "") -> Landmark:
    return Landmark(SegmentationLabel(kind, colour), x, z, seen, seen[0] if seen else None)


VIEW = Pose(0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("rival", "named"),
    [
        (mark("bin", 0.5, 12.0, 0), None),  # not clearly farther away
        (mark("bin", 0.5, 20.0, 0), (Thing("bin"), True)),
        (mark("bin", 0.5, 8.0, 0), None),
        (mark("bin", 0.5, 8.0), (Thing("bin"), False)),  # nearer, but never seen
        (mark("bin", 0.5, 8.0, 90), (Thing("bin"), False)),  # seen too late to be mistaken
        (mark("bin", 0.5, -8.0, 0), (Thing("bin"), True)),  # behind
        (mark("bench", 0.5, 8.0, 0), (Thing("bin"), True)),
    ],
)
def test_landmark_names_are_unambiguous(rival: Landmark, named: tuple[Thing, bool] | None) -> None:
    own = mark("bin", 1.0, 9.0, 0)
    assert unique_name(own, [own, rival], VIEW, 10, seeded("name")) == named


def test_colour_distinguishes_landmarks_of_one_kind() -> None:
    own, rival = mark("cone", 0.0, 9.0, 0, colour="red"), mark("cone", 0.0, 8.0, 0, colour="blue")
    assert {unique_name(own, [own, rival], VIEW, 10, seeded("cone", i)) for i in range(9)} == {
        (Thing("cone", "red"), True)
    }
    far = replace(rival, z=30.0)
    names = {unique_name(own, [own, far], VIEW, 10, seeded("cone", i)) for i in range(9)}
    assert names == {(Thing("cone"), True), (Thing("cone", "red"), True)}


def test_short_target_names_remain_unique() -> None:
    target = STREET[0]
    poses = poses_along(START, PATH, ACTIONS)
    seen = Landmark(SegmentationLabel("mug", "red", "striped"), target.position.x, target.position.z, (len(poses) - 1,))
    names = {describe_target(target, STREET, [seen], poses, seeded("name", i)) for i in range(60)}
    assert names == {Thing("mug", "red", "striped"), Thing("mug", "", "striped")}
