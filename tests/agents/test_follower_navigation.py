"""The follower in the street: what it makes of frames, and how it does what instructions mean."""

import math
from collections.abc import Iterator

import numpy as np
import pytest

from agents.follower.map import Map, index
from agents.follower.map_landmarks import Landmark, along_way, fits
from agents.follower.navigation import Navigator
from agents.follower.navigation_body import Body
from agents.follower.navigation_motion import can_step, turns, way_to
from agents.follower.navigation_places import all_openings
from arramon_client.agent import Action, Label, Observation
from lang.meaning import Face, Navigation, Step, Thing, Turn, Walk
from server.sim import rules
from server.sim.bullet import World
from server.sim.city import city_scene
from server.sim.geometry import Pose
from server.sim.labels import places_of
from server.sim.raster import RasterCamera
from server.sim.rules import Collectible, Layout, Limits, Phase, State
from server.sim.view import view
from server.trial import AGENT_LABELS
from tests.episodes.instruct.town import START, STREET, crossing, thing

MUG = Thing("mug", "red", "striped")
BOOTH, HYDRANT, BENCH = Thing("phone_booth"), Thing("hydrant"), Thing("bench")


class Street:
    """The small crossing, played without a server."""

    def __init__(self) -> None:
        scene = city_scene(crossing())
        self.world, self.camera = World(scene), RasterCamera(scene)
        self.places = places_of(self.camera.labels)

    def observe(self, state: State, layout: Layout) -> Observation:
        seen = view(state, layout)
        frame = self.camera.render(seen.viewpoint, seen.actors, 128, segmentation=True)
        depth = frame.depth.astype(np.float32) / np.float32(1000)
        assert frame.segmentation is not None
        segmentation = self.places[frame.segmentation]
        return Observation("e", 1, "navigation", 0, "", 0, 150, depth=depth, segmentation=segmentation)

    def play(
        self, meaning: Navigation, start: Pose = START, street: tuple[Collectible, ...] = STREET
    ) -> tuple[State, list[Action]]:
        """The state when the navigation has ended, and what was done."""
        layout = Layout(start, (street, street), ())
        state, body, actions = rules.begin(layout), Body(AGENT_LABELS), []
        navigator = Navigator(body, meaning)
        while state.phase is Phase.NAVIGATION:
            body.perceive(self.observe(state, layout))
            actions.append(navigator.act())
            body.did(actions[-1])
            state, _ = rules.step(state, rules.Action(actions[-1]), layout, self.world, Limits())
        return state, actions


@pytest.fixture(scope="module")
def street() -> Iterator[Street]:
    made = Street()
    yield made
    made.world.close()


@pytest.mark.parametrize(
    "steps",
    [
        (Turn("right", "after", BOOTH),),
        (Turn("right", "before", HYDRANT),),
        (Turn("right", "at", Thing("intersection")),),
        (Walk("past", (BOOTH,), "right"), Turn("right"), Walk("past", (BENCH,))),
        (Walk("between", (BOOTH, HYDRANT)), Turn("right")),
        (Face(BOOTH), Walk("to", (BOOTH,)), Turn("right"), Walk("towards", (BENCH,))),
        (Walk("ahead", count=15), Turn("right"), Walk("ahead")),
    ],
)
def test_it_does_what_the_steps_mean(street: Street, steps: tuple[Step, ...]) -> None:
    state, actions = street.play(Navigation(steps, MUG))
    assert state.carried == STREET[0].type
    assert len(actions) < 60  # the ground truth takes 31
    assert math.dist((state.pose.x, state.pose.z), (12.0, 0.0)) < 2.0


@pytest.mark.parametrize(
    ("steps", "end"),
    [
        ((Turn("left", "at", Thing("intersection")),), (-10.0, 0.0)),
        ((Walk("past", (HYDRANT,)),), (0.0, 10.5)),
        ((Turn("around"),), (0.0, -18.5)),
    ],
)
def test_the_steps_say_which_way(street: Street, steps: tuple[Step, ...], end: tuple[float, float]) -> None:
    """The same crossing with the target elsewhere."""
    aim = (end[0] * 1.15, end[1] + math.copysign(1.5, end[1]) * (end[0] == 0.0))
    state, actions = street.play(Navigation(steps, MUG), street=(thing("striped red mug", *aim),))
    assert state.carried == STREET[0].type
    assert len(actions) < 70
    assert math.dist((state.pose.x, state.pose.z), end) < 2.5


def test_it_looks_for_a_target_that_the_steps_do_not_lead_to(street: Street) -> None:
    state, _ = street.play(Navigation((), MUG))
    assert state.carried == STREET[0].type


def test_it_takes_the_right_one_of_two_beside_each_other(street: Street) -> None:
    both = (thing("striped red mug", 0.6, -8.0), thing("dotted red mug", 0.0, -9.0))
    state, _ = street.play(Navigation((Walk("ahead"),), MUG), street=both)
    assert state.carried == both[0].type


def test_the_same_frames_give_the_same_actions(street: Street) -> None:
    meaning = Navigation((Turn("right", "after", BOOTH),), MUG)
    assert street.play(meaning)[1] == street.play(meaning)[1]


def test_a_blocked_step_is_known_by_the_frame(street: Street) -> None:
    layout = Layout(Pose(0.0, -22.0, 180.0), (STREET, STREET), ())
    state, body = rules.begin(layout), Body(AGENT_LABELS)
    for _ in range(3):  # the street ends at z = -23
        body.perceive(street.observe(state, layout))
        body.did(Action.FORWARD)
        state, _ = rules.step(state, rules.Action.FORWARD, layout, street.world, Limits())
    body.perceive(street.observe(state, layout))
    assert (body.x, body.z, body.travelled) == (0.0, 0.0, 0)
    assert body.closed_steps == {(0, 0, 0)}


def test_things_are_seen_where_they_stand(street: Street) -> None:
    layout = Layout(START, (STREET, STREET), ())
    body = Body(AGENT_LABELS)
    body.perceive(street.observe(rules.begin(layout), layout))
    (booth,) = body.landmarks.fitting(BOOTH)
    assert math.dist((booth.x, booth.z), (2.4, 11.6)) < 0.5  # in the own frame, from where it begins
    assert body.ground.blocked[index(2.4, 11.3)]
    assert body.ground.free[index(0.0, 8.0)]
    assert not body.ground.blocked[index(0.0, 8.0)]


def test_it_needs_depth_and_segmentation() -> None:
    with pytest.raises(ValueError, match="depth and segmentation"):
        Body(AGENT_LABELS).perceive(Observation("e", 1, "navigation", 0, "", 0, 150))


@pytest.mark.parametrize(("heading", "to", "rotation"), [(0, 3, "RRR"), (0, 9, "LLL"), (11, 1, "RR"), (5, 5, "")])
def test_turns_go_the_short_way(heading: int, to: int, rotation: str) -> None:
    assert "".join("FLR"[action] for action in turns(heading, to)) == rotation


def test_a_way_goes_round_what_is_solid() -> None:
    ground = Map()
    for i in range(-8, 9):
        ground.block(i * 0.25, 3.0)
    assert not can_step(ground, 0.0, 2.0, 0)
    actions = way_to(ground, (0.0, 0.0, 0), (0.0, 6.0), 0.6)
    x, z, heading, farthest = 0.0, 0.0, 0, 0.0
    for action in actions:
        heading += {Action.LEFT: -1, Action.RIGHT: 1}.get(action, 0)
        if action is Action.FORWARD:
            x, z = x + math.sin(math.radians(30 * heading)), z + math.cos(math.radians(30 * heading))
        farthest = max(farthest, abs(x))
    assert math.hypot(x, z - 6.0) <= 0.6
    assert farthest > 2.0


def test_no_way_is_needed_where_one_is_there() -> None:
    assert way_to(Map(), (0.0, 0.0, 0), (0.3, 0.3), 0.6) == []


@pytest.mark.parametrize(
    ("runs", "walls", "opening"),
    [
        ([3.0] * 4 + [7.0] * 4, [True] * 4 + [False] * 4, 4),
        ([3.0] * 4 + [7.0] * 2 + [3.0] * 4, [True] * 4 + [False] * 2 + [True] * 4, None),  # too narrow
        ([3.0] * 4 + [1.0] * 3 + [4.5] * 4, [True] * 4 + [False] * 7, 4),  # its near part is not seen yet
        ([7.0] * 8, [False] * 8, None),  # open all along: nothing opens
        ([3.0] * 4 + [4.0] * 4, [True] * 8, None),  # a recess
    ],
)
def test_an_opening_is_deeper_than_the_wall_before_it(
    runs: list[float], walls: list[bool], opening: int | None
) -> None:
    assert all_openings(runs, walls) == ([] if opening is None else [opening])


CONE = Label("cone", "red")


def test_what_is_ahead_and_near_is_meant_first() -> None:
    marks = [Landmark(CONE, x, z, 1.0) for x, z in ((0.0, 9.0), (6.0, 4.0), (0.0, 5.0), (0.0, -4.0), (6.0, 1.0))]
    assert [(mark.x, mark.z) for mark in along_way(marks, 0.0, 0.0, 0.0)] == [(0.0, 5.0), (0.0, 9.0), (6.0, 4.0)]


@pytest.mark.parametrize(
    ("name", "label", "fitting"),
    [
        (Thing("cone"), CONE, True),
        (Thing("cone", "red"), CONE, True),
        (Thing("cone", "blue"), CONE, False),
        (Thing("", "red"), CONE, False),  # only collectibles go without their kind
        (Thing("", "red"), Label("mug", "red", "dotted"), True),
        (Thing("mug", "", "striped"), Label("mug", "red", "dotted"), False),
    ],
)
def test_a_name_fits_as_far_as_it_goes(name: Thing, label: Label, fitting: bool) -> None:
    assert fits(name, label) is fitting
