"""Input features of the policy: shapes, egocentric positions, matches with the instruction, mirror images."""

import math

import numpy as np
import pytest

from arramon_agents.mapping.ground_map import GroundMap
from arramon_agents.mapping.landmark_memory import MappedLandmark
from arramon_agents.mapping.probabilistic_landmark_memory import LandmarkBelief, one_hot_of
from arramon_agents.perception.eyes.vocabulary import COLOURS, KINDS
from arramon_agents.perception.scan import Scan
from arramon_agents.reading.reader.slots import SLOTS, Row, rows_of
from arramon_agents.vl_map.features import (
    DIRECTIONS,
    GROUND_CHANNELS,
    RADII,
    ROWS,
    THING_VALUES,
    THINGS,
    TRACE,
    TRACE_VALUES,
    AgentKnowledge,
    PolicyInput,
    match_of,
    mirror,
    policy_input,
)
from arramon_client.agent import Label
from arramon_lang.meaning import Navigation, Rotate, Thing, Walk, Where

MUG = Thing("mug", "red", "dotted", where=(Where("left_of", (Thing("bench"),)),))
MEANING = Navigation((Rotate("left", "at", Thing("cone", "orange")), Walk("past", (Thing("bench"),), "right")), MUG)


def belief(kind: str, colour: str = "", look: str = "", at: tuple[float, float] = (0.0, 0.0)) -> LandmarkBelief:
    label = Label(kind, colour, look)
    return LandmarkBelief(MappedLandmark(label, *at, 1.0), *one_hot_of(label))


def ground(side: int = 1) -> GroundMap:
    """A street ahead, and a wall to one side (1 for the right)."""
    known = GroundMap()
    ahead = np.arange(0.06, 12.0, 0.125)
    free = np.stack(np.meshgrid(np.arange(-1.5625, 1.6, 0.125), ahead), -1).reshape(-1, 2)
    wall = np.stack([np.full(len(ahead), 2.6 * side), ahead], 1)
    known.add(Scan(wall.astype(np.float32), np.ones(len(wall), bool), free.astype(np.float32)))
    return known


def moment(side: int = 1, heading: float = 0.0) -> AgentKnowledge:
    beliefs = [
        belief("cone", "orange", at=(2.0 * side, 3.0)),
        belief("bench", at=(-1.0 * side, -2.0)),
        belief("mug", "red", "dotted", at=(-4.0 * side, 6.0)),
        belief("car", "blue", at=(0.0, 100.0)),
    ]
    trace = [(0.0, -4.0, 0.0), (0.0, -3.0, 0.0), (0.0, -2.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, heading)]
    return AgentKnowledge(ground(side), trace, beliefs, 100, 1)


def sample(side: int = 1, meaning: Navigation = MEANING) -> tuple[PolicyInput, list[LandmarkBelief]]:
    return policy_input(rows_of(meaning), moment(side))


def test_shapes() -> None:
    given, beliefs = sample()
    shapes = {name: getattr(given, name).shape for name in PolicyInput._fields}
    assert shapes == {
        "rows": (ROWS, len(SLOTS)),
        "ground": (DIRECTIONS, len(RADII), GROUND_CHANNELS),
        "things": (THINGS, THING_VALUES),
        "match": (2, ROWS, THINGS),
        "trace": (TRACE, TRACE_VALUES),
        "state": (6,),
    }
    assert [each.mark.label.kind for each in beliefs] == ["bench", "cone", "mug"]  # What is far away is left out.
    assert given.things[:, 0].tolist() == [1.0] * 3 + [0.0] * (THINGS - 3)


def test_things_are_given_as_the_agent_faces_them() -> None:
    given, _ = policy_input(rows_of(MEANING), moment(heading=math.pi / 2))  # It has turned to the right.
    bench, cone, mug = given.things[:3]
    assert cone[1:3] == pytest.approx((-3.0, 2.0), abs=1e-6)
    assert mug[1:3] == pytest.approx((-6.0, -4.0), abs=1e-6)
    # It was nearest to the bench two moves ago, and passed it on its left.
    assert bench[3:6] == pytest.approx((-1.0, 0.0, 2.0), abs=1e-6)


@pytest.mark.parametrize(
    ("thing", "expected"),
    [
        (Thing("cone", "orange"), [1, 0, 0, 0]),
        (Thing("cone", "red"), [0, 0, 0, 0]),
        (Thing("", "red", "dotted"), [0, 0, 1, 0]),
        (Thing("bench"), [0, 1, 0, 0]),
        (Thing("bench", "brown"), [0, 1, 0, 0]),  # Benches are brown: their label does not say so.
        (Thing("intersection"), [0, 0, 0, 0]),
    ],
)
def test_match(thing: Thing, expected: list[float]) -> None:
    rows: list[Row] = rows_of(Navigation((Walk("to", (thing,)),), Thing("tv")))
    assert match_of(rows, moment().beliefs)[0, 0].tolist() == expected


def test_match_of_what_is_unsure() -> None:
    kinds, colours, looks = (part.copy() for part in one_hot_of(Label("mug", "red", "dotted")))
    kinds[KINDS.index("mug")], kinds[KINDS.index("bowl")] = 0.75, 0.25
    colours[COLOURS.index("red")] = 0.5
    unsure = LandmarkBelief(MappedLandmark(Label("mug"), 0.0, 1.0, 1.0), kinds, colours, looks)
    rows = rows_of(Navigation((), Thing("mug", "red", "dotted")))
    assert match_of(rows, [unsure])[0, 0].tolist() == [0.375]


def test_ground() -> None:
    given, _ = sample()
    free, blocked, wall = given.ground[0].T  # Ahead.
    assert free.all()
    assert not blocked.any()
    assert not wall.any()
    assert given.ground[5, 3].tolist() == [0, 1, 1]  # Almost to the right, up to 3 units away: a wall.


def test_what_tells_the_place_of_the_target() -> None:
    given, _ = sample()
    mug = given.things[2]
    assert mug[12] == pytest.approx(math.hypot(3.0, 8.0) / 10.0)


def test_mirror_image() -> None:
    given, _ = sample()
    meant = Navigation(
        (Rotate("right", "at", Thing("cone", "orange")), Walk("past", (Thing("bench"),), "left")),
        Thing("mug", "red", "dotted", where=(Where("right_of", (Thing("bench"),)),)),
    )
    other, _ = sample(-1, meant)
    image = mirror(given)
    for name in ("rows", "things", "match", "trace", "state"):
        np.testing.assert_allclose(getattr(image, name), getattr(other, name), atol=1e-6, err_msg=name)
    # The map's cells have no mirror image at their edges.
    assert (image.ground != other.ground).mean() < 0.01
    assert (given.ground != other.ground).mean() > 0.025
    for name in PolicyInput._fields:
        np.testing.assert_array_equal(getattr(mirror(image), name), getattr(given, name), err_msg=name)
