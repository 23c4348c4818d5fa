"""Simulated walks: what the body perceives in a small street, labels of decisions, and walks that follow them."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from arramon_agents.reading.reader.reader import load
from arramon_agents.simulated.body import PerceptionErrorRates, SimulatedBody
from arramon_agents.simulated.courses import Course, training_courses
from arramon_agents.simulated.room_examples import room_examples_of
from arramon_agents.simulated.walks import score, walk
from arramon_agents.simulated.world import StreetWorld, Things
from arramon_agents.vl_map.options import OPTIONS
from arramon_client.agent import Action
from arramon_client.errors import UsageError
from arramon_lang.meaning import Thing
from arramon_server.episodes.episode import Instructions
from arramon_server.episodes.splits import write_split
from arramon_server.sim.section import Building, Prop, Section
from tests import tiny

PERFECT = PerceptionErrorRates().scaled(0.0)

STREET = Section(
    "1",
    0.0,
    (-20.0, -20.0, 20.0, 20.0),
    (Building(0.0, 12.0, 5.0, 1.0, 0.0, 3.0, "brick"),),
    (
        Prop("cone", 1.0, 4.0, 0.0, "orange"),
        Prop("bench", 0.0, 15.0, 0.0),  # Behind the building.
        Prop("bin", 0.0, -4.0, 0.0),  # Behind the agent.
    ),
)


def body(*, faults: PerceptionErrorRates = PERFECT, heading: float = 0.0) -> SimulatedBody:
    world = StreetWorld(STREET)
    return SimulatedBody(world, Things(world.props, []), (0.0, 0.0, heading), faults, np.random.default_rng(4))


def test_rays() -> None:
    solid, wall, house = StreetWorld(STREET).cast(0.0, 0.0, np.array([0.0, math.atan2(1.0, 4.0), math.pi]), 30.0)
    assert solid[:2] == pytest.approx([11.0, 3.97], abs=0.2)
    assert wall[0] == pytest.approx(11.0, abs=0.2)
    assert house.tolist() == [1, 1, 0]


def test_what_is_in_sight_is_remembered() -> None:
    seen = body()
    seen.observe()
    (cone,) = seen.landmarks.matching(Thing("cone", "orange"))
    assert (cone.x, cone.z) == pytest.approx((1.0, 4.0), abs=0.2)
    assert seen.landmarks.matching(Thing("bench")) == []
    assert seen.landmarks.matching(Thing("bin")) == []
    assert seen.landmarks.matching(Thing("building", look="brick"))
    assert seen.ground.has_line_of_sight(0.0, 0.0, 0.0, 8.0)
    assert not seen.ground.has_line_of_sight(0.0, 0.0, 0.0, 13.0)


def test_places_are_in_the_agents_own_frame() -> None:
    seen = body(heading=math.radians(30.0))
    seen.apply(Action.LEFT)
    seen.observe()
    (cone,) = seen.landmarks.matching(Thing("cone"))
    own = seen.frame.to_own(1.0, 4.0)
    assert (cone.x, cone.z) == pytest.approx(own, abs=0.2)
    assert seen.frame.to_world(*own) == pytest.approx((1.0, 4.0))


def test_a_step_into_something_solid_is_blocked() -> None:
    seen = body(heading=math.atan2(1.0, 4.0))
    for _ in range(5):
        seen.apply(Action.FORWARD)
    assert seen.travelled == 3
    assert seen.world_pose[:2] == pytest.approx((3.0 / math.sqrt(17.0), 12.0 / math.sqrt(17.0)))
    assert seen.closed_steps


def test_faults_are_as_frequent_as_told() -> None:
    found, world = {}, StreetWorld(STREET)
    for name, share in (("none", 0.0), ("many", 8.0)):
        names = []
        for number in range(40):
            random = np.random.default_rng(number)
            seen = SimulatedBody(
                world, Things(world.props, []), (0.0, 0.0, 0.0), PerceptionErrorRates().scaled(share), random
            )
            seen.observe()
            names += [mark.label.kind for mark in seen.landmarks.matching(Thing("cone", "orange"))]
        found[name] = len(names)
    assert found["none"] == 40
    assert found["many"] < 30


@pytest.fixture(scope="module")
def courses(tmp_path_factory: pytest.TempPathFactory) -> list[Course]:
    data = tmp_path_factory.mktemp("walks")
    tiny.write(data, "train", 3)
    found = training_courses(data, ("en", "hi"), 0, load())
    assert len(found.data_hash) == 64
    assert [split for split, _ in found.names] == ["train", "train"]
    return [course for pair in found.pairs for course in pair]


def test_turns_are_read(courses: list[Course]) -> None:
    assert len(courses) == 4  # One of the three episodes has no Hindi.
    assert [course.turn for course in courses] == [1, 2, 1, 2]
    assert len(courses[0].readings) == 3
    assert courses[1].start == pytest.approx((0.0, 2.0, 0.0))


def test_a_walk_by_the_right_decisions_picks_up_the_target(courses: list[Course]) -> None:
    for course in courses:
        walked = walk(course, course.readings[0], PERFECT, np.random.default_rng(1), astray=0.0)
        assert walked.picked == 0
        assert walked.decisions[-1].label.thing >= 0
        assert np.hypot(*(walked.path[-1] - course.target)) < 3.0


def test_walks_that_go_astray_come_back(courses: list[Course]) -> None:
    picked = [
        walk(course, course.readings[0], PerceptionErrorRates(), np.random.default_rng((1, number)), astray=0.4).picked
        for number in range(3)
        for course in courses
    ]
    assert picked.count(0) >= 8


def test_score(courses: list[Course]) -> None:
    still = np.zeros(OPTIONS, np.float32)
    scores = score(courses[:2], lambda sample, beliefs: still, 0, PERFECT)
    assert set(scores) == {"nDTW", "picked", "CTC-3"}
    assert scores["nDTW"] < 0.9


def test_missing_data_is_told(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="there are no episodes in "):
        training_courses(tmp_path, ("en",), 0, load())
    tiny.write(tmp_path, "train", 2)
    with pytest.raises(ValueError, match="the split 'train' has no language 'fr'; it has en, hi"):
        training_courses(tmp_path, ("fr",), 0, load())


def test_a_text_that_the_grammar_cannot_parse_has_the_readers_output_alone(tmp_path: Path) -> None:
    texts = Instructions("Mosey on over yonder, partner.", "Howdy, partner.")
    free = replace(tiny.episode("1", ("en",)), instructions={"en": (texts, texts)})
    write_split(tmp_path, "train", hidden=False, source="tests", episodes=[free], sections=[tiny.SECTION])
    (pair,) = training_courses(tmp_path, ("en",), 0, load()).pairs
    assert [len(course.readings) for course in pair] == [1, 1]
    assert [len(example.readings) for example in room_examples_of([free], ("en",), load())] == [1, 1]
