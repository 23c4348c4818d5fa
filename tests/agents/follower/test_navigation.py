"""The follower's navigation: perception of frames, paths, and execution of instructions."""

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from arramon_agents.follower.navigation import Navigator
from arramon_agents.follower.side_streets import find_side_streets
from arramon_agents.mapping.body import AgentBody
from arramon_agents.mapping.ground_map import cell_index
from arramon_agents.mapping.landmark_memory import MappedLandmark, landmarks_ahead, matches_label
from arramon_agents.mapping.motion import turns
from arramon_agents.mapping.notes import outline
from arramon_agents.perception.scan import Sighting
from arramon_client.agent import Action, Label, Observation
from arramon_dataset.trial import AGENT_LABELS
from arramon_lang.meaning import Face, Navigation, Rotate, Step, Thing, Walk, Where
from arramon_server.sim import rules
from arramon_server.sim.city import city_scene
from arramon_server.sim.geometry import Pose
from arramon_server.sim.labels import places_of
from arramon_server.sim.physics import physics_of
from arramon_server.sim.raster.camera import RasterCamera
from arramon_server.sim.rules import Collectible, EpisodeLayout, Limits, Phase, State
from arramon_server.sim.view import view
from tests.dataset.instructions.town import START, STREET, crossing, thing

MUG = Thing("mug", "red", "striped")
BOOTH, HYDRANT, BENCH = Thing("phone_booth"), Thing("hydrant"), Thing("bench")


class Street:
    """A small crossing, simulated without a server."""

    def __init__(self) -> None:
        scene = city_scene(crossing())
        self.world, self.camera = physics_of(scene), RasterCamera(scene)
        self.places = places_of(self.camera.labels)

    def observe(self, state: State, layout: EpisodeLayout) -> Observation:
        seen = view(state, layout)
        frame = self.camera.render(seen.viewpoint, seen.actors, 128, segmentation=True)
        depth = frame.depth.astype(np.float32) / np.float32(1000)
        assert frame.segmentation is not None
        segmentation = self.places[frame.segmentation]
        return Observation("e", 1, "navigation", 0, "", 0, 150, depth=depth, segmentation=segmentation)

    def play(
        self,
        meaning: Navigation,
        start: Pose = START,
        street: tuple[Collectible, ...] = STREET,
        imagined: tuple[tuple[float, float], ...] = (),
    ) -> tuple[State, list[Action]]:
        """The state when the navigation has ended, and what was done, with obstacles on the map that are not there."""
        layout = EpisodeLayout(start, (street, street), ())
        state, body, actions = rules.begin(layout), AgentBody(AGENT_LABELS), []
        for x, z in imagined:
            body.ground.block(x, z)
        navigator, self.body = Navigator(body, meaning), body
        self.intents: list[Any] = []
        while state.phase is Phase.NAVIGATION:
            body.perceive(self.observe(state, layout))
            actions.append(navigator.act())
            self.intents.append(navigator.intent())
            body.record_action(actions[-1])
            state, _ = rules.step(state, Action(actions[-1]), layout, self.world, Limits())
        return state, actions


@pytest.fixture(scope="module")
def street() -> Iterator[Street]:
    made = Street()
    yield made
    made.world.close()


@pytest.mark.parametrize(
    "steps",
    [
        (Rotate("right", "after", BOOTH),),
        (Rotate("right", "before", HYDRANT),),
        (Rotate("right", "at", Thing("intersection")),),
        (Walk("past", (BOOTH,), "right"), Rotate("right"), Walk("past", (BENCH,))),
        (Walk("between", (BOOTH, HYDRANT)), Rotate("right")),
        (Face(BOOTH), Walk("to", (BOOTH,)), Rotate("right"), Walk("towards", (BENCH,))),
        (Walk("ahead", count=15), Rotate("right"), Walk("ahead")),
    ],
)
def test_instructed_steps_lead_to_the_target(street: Street, steps: tuple[Step, ...]) -> None:
    state, actions = street.play(Navigation(steps, MUG))
    assert state.carried == STREET[0].type
    assert len(actions) < 60  # the ground truth takes 31
    assert math.dist((state.pose.x, state.pose.z), (12.0, 0.0)) < 2.0
    numbers = [intent["step"] for intent in street.intents if "step" in intent]
    assert numbers == sorted(numbers)
    assert set(numbers) <= set(range(1, len(steps) + 1))
    assert street.intents[-1]["take"] == outline(MUG)
    assert any("goal" in intent for intent in street.intents)
    assert street.body.taken is not None
    lying = STREET[0].position.x - START.x, STREET[0].position.z - START.z  # START faces +z, as the body's frame.
    assert math.dist(street.body.taken, lying) < 0.3


@pytest.mark.parametrize(
    ("steps", "end"),
    [
        ((Rotate("left", "at", Thing("intersection")),), (-10.0, 0.0)),
        ((Walk("past", (HYDRANT,)),), (0.0, 10.5)),
        ((Rotate("around"),), (0.0, -18.5)),
    ],
)
def test_instructed_steps_determine_the_direction(
    street: Street, steps: tuple[Step, ...], end: tuple[float, float]
) -> None:
    """The same crossing with the target elsewhere."""
    aim = (end[0] * 1.15, end[1] + math.copysign(1.5, end[1]) * (end[0] == 0.0))
    state, actions = street.play(Navigation(steps, MUG), street=(thing("striped red mug", *aim),))
    assert state.carried == STREET[0].type
    assert len(actions) < 70
    assert math.dist((state.pose.x, state.pose.z), end) < 2.5


def test_target_is_found_without_any_instructed_steps(street: Street) -> None:
    state, _ = street.play(Navigation((), MUG))
    assert state.carried == STREET[0].type


@pytest.mark.parametrize(
    ("name", "is_taken"), [("dotted red mug", True), ("striped blue mug", True), ("dotted blue mug", False)]
)
def test_an_object_that_differs_in_one_attribute_is_taken_in_the_end(street: Street, name: str, is_taken: bool) -> None:
    _, actions = street.play(Navigation((), MUG), street=(thing(name, 0.0, -9.0),))
    assert (Action.INTERACT in actions) == is_taken


def test_the_target_is_taken_before_what_resembles_it(street: Street) -> None:
    things = thing("striped red mug", 0.0, 4.0), thing("dotted red mug", 0.0, -9.0)
    state, _ = street.play(Navigation((), replace(MUG, where=(Where("near", (BENCH,)),))), street=things)
    assert state.carried == things[0].type


def test_a_map_without_any_way_out_is_not_believed(street: Street) -> None:
    around = [math.radians(degrees) for degrees in range(0, 360, 10)]
    state, actions = street.play(
        Navigation((), MUG), imagined=tuple((0.9 * math.sin(each), 0.9 * math.cos(each)) for each in around)
    )
    assert state.carried == STREET[0].type
    assert len(actions) < 100


def test_a_building_is_passed_along_the_street_however_far_aside_it_stands() -> None:
    label = next(
        number for number, label in enumerate(AGENT_LABELS) if (label.kind, label.look) == ("building", "brick")
    )
    body = AgentBody(AGENT_LABELS)
    body.landmarks.add([Sighting(label, 7.0, 7.0, 9.9, 40)])
    navigator = Navigator(body, Navigation((Walk("past", (Thing("building", look="brick"),)),), MUG))
    assert navigator.act() is Action.FORWARD
    across, ahead = navigator.intent()["goal"]
    assert abs(across) < 0.5 < ahead


def test_matching_one_of_two_adjacent_objects_is_picked_up(street: Street) -> None:
    both = (thing("striped red mug", 0.6, -8.0), thing("dotted red mug", 0.0, -9.0))
    state, _ = street.play(Navigation((Walk("ahead"),), MUG), street=both)
    assert state.carried == both[0].type


def test_the_same_frames_give_the_same_actions(street: Street) -> None:
    meaning = Navigation((Rotate("right", "after", BOOTH),), MUG)
    assert street.play(meaning)[1] == street.play(meaning)[1]


def test_a_blocked_step_is_detected_by_the_frame(street: Street) -> None:
    layout = EpisodeLayout(Pose(0.0, -22.0, 180.0), (STREET, STREET), ())
    state, body = rules.begin(layout), AgentBody(AGENT_LABELS)
    for _ in range(3):  # the street ends at z = -23
        body.perceive(street.observe(state, layout))
        body.record_action(Action.FORWARD)
        state, _ = rules.step(state, Action.FORWARD, layout, street.world, Limits())
    body.perceive(street.observe(state, layout))
    assert (body.x, body.z, body.travelled) == (0.0, 0.0, 0)
    assert body.closed_steps == {(0, 0, 0)}


def test_landmarks_and_free_ground_are_located_in_a_frame(street: Street) -> None:
    layout = EpisodeLayout(START, (STREET, STREET), ())
    body = AgentBody(AGENT_LABELS)
    body.perceive(street.observe(rules.begin(layout), layout))
    (booth,) = body.landmarks.matching(BOOTH)
    assert math.dist((booth.x, booth.z), (2.4, 11.6)) < 0.5  # in the own frame, from where it begins
    assert body.ground.blocked[cell_index(2.4, 11.3)]
    assert body.ground.free[cell_index(0.0, 8.0)]
    assert not body.ground.blocked[cell_index(0.0, 8.0)]


def test_depth_and_segmentation_are_required() -> None:
    with pytest.raises(ValueError, match="depth and segmentation"):
        AgentBody(AGENT_LABELS).perceive(Observation("e", 1, "navigation", 0, "", 0, 150))


@pytest.mark.parametrize(("heading", "to", "rotation"), [(0, 3, "RRR"), (0, 9, "LLL"), (11, 1, "RR"), (5, 5, "")])
def test_turns_take_the_shorter_direction(heading: int, to: int, rotation: str) -> None:
    assert "".join("FLR"[action] for action in turns(heading, to)) == rotation


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
def test_openings_are_found_where_depth_exceeds_the_wall(
    runs: list[float], walls: list[bool], opening: int | None
) -> None:
    assert find_side_streets(runs, walls) == ([] if opening is None else [opening])


CONE = Label("cone", "red")


def test_near_landmarks_ahead_come_first() -> None:
    marks = [MappedLandmark(CONE, x, z, 1.0) for x, z in ((0.0, 9.0), (6.0, 4.0), (0.0, 5.0), (0.0, -4.0), (6.0, 1.0))]
    assert [(mark.x, mark.z) for mark in landmarks_ahead(marks, 0.0, 0.0, 0.0)] == [(0.0, 5.0), (0.0, 9.0), (6.0, 4.0)]


@pytest.mark.parametrize(
    ("name", "label", "fitting"),
    [
        (Thing("cone"), CONE, True),
        (Thing("cone", "red"), CONE, True),
        (Thing("cone", "blue"), CONE, False),
        (Thing("bin", "green"), Label("bin"), True),
        (Thing("bin", "green"), Label("bin", "black"), False),
        (Thing("bin", "red"), Label("bin"), False),
        (Thing("", "red"), CONE, False),  # only collectibles go without their kind
        (Thing("", "red"), Label("mug", "red", "dotted"), True),
        (Thing("mug", "", "striped"), Label("mug", "red", "dotted"), False),
    ],
)
def test_a_thing_matches_by_its_given_attributes(name: Thing, label: Label, fitting: bool) -> None:
    assert matches_label(name, label) is fitting


TWIN = thing("striped red mug", 1.5, -7.0)
"""In view from the start, and nearer than the target."""


def test_another_object_like_the_target_is_passed_by_where_the_place_is_told(street: Street) -> None:
    ball = thing("dotted blue ball", 12.0, 1.5)
    listed = (*STREET, TWIN, ball)
    named = Thing("mug", "red", "striped", where=(Where("near", (Thing("ball", "blue", "dotted"),)),))
    steps = (Rotate("right", "at", Thing("intersection")),)
    told, _ = street.play(Navigation(steps, named), street=listed)
    by_name, _ = street.play(Navigation(steps, MUG), street=listed)
    assert math.dist((told.pose.x, told.pose.z), (13.5, 0.0)) < 3.0
    assert math.dist((by_name.pose.x, by_name.pose.z), (1.5, -7.0)) < 3.0
