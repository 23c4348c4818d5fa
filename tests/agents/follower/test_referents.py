"""Reference resolution of the follower: the landmarks that an instruction refers to."""

import math

import numpy as np
import pytest

from arramon_agents.follower.referents import Referents
from arramon_agents.follower.side_streets import SideStreets
from arramon_agents.mapping.ground_map import GroundMap
from arramon_agents.mapping.landmark_memory import LandmarkMemory
from arramon_agents.perception.scan import Scan, Sighting
from arramon_client.agent import Label
from arramon_lang.meaning import Thing, Where

LABELS = (Label("bench"), Label("cone", "red"), Label("cone", "blue"), Label("building", "", "brick"))


def seen(*things: tuple[int, float, float]) -> LandmarkMemory:
    landmarks = LandmarkMemory(LABELS)
    landmarks.add(Sighting(label, x, z, math.hypot(x, z), 50) for label, x, z in things)
    return landmarks


STREET = seen(
    (0, 1.0, 5.0), (0, -1.0, 9.0), (0, 1.5, 20.0), (1, -2.0, 7.0), (2, -2.0, 9.0), (3, 4.0, 8.0), (3, 4.0, 12.0)
)
NEXT_TO_BLUE = Thing("bench", where=(Where("near", (Thing("cone", "blue"),)),))


@pytest.mark.parametrize(
    ("thing", "places"),
    [
        (Thing("bench"), [5.0]),
        (Thing("bench", which="second"), [9.0]),
        (Thing("bench", which="third"), [20.0]),
        (Thing("bench", which="last"), [20.0]),
        (Thing("bench", number="two"), [5.0, 9.0]),
        (Thing("cone", number="several"), [7.0, 9.0]),
        (NEXT_TO_BLUE, [9.0]),
        (Thing("building", look="brick"), [8.0, 12.0]),
        (Thing("cone", "red", which="second"), None),
        (Thing("cone", "red", number="two"), None),
        (Thing("tree"), None),
    ],
)
def test_what_a_thing_is(thing: Thing, places: list[float] | None) -> None:
    found = Referents(STREET).find(thing, 0.0, 0.0, 0.0)
    assert (None if found is None else [mark.z for mark in found]) == places


def test_a_thing_is_the_same_again_and_another_is_another() -> None:
    referents = Referents(STREET)
    first = referents.find(Thing("bench", identity="1"), 0.0, 0.0, 0.0)
    assert first is not None
    referents.store(Thing("bench", identity="1"), first)
    assert referents.find(Thing("bench", identity="1"), 0.0, 15.0, 0.0) == first
    for which in ("next", "another"):
        other = referents.find(Thing("bench", which=which, identity="2"), 0.0, 0.0, 0.0)
        assert other is not None
        assert [mark.z for mark in other] == [9.0]


def test_streets_are_counted_along_the_walk() -> None:
    ground = GroundMap()
    xs, zs = np.meshgrid(np.arange(-8.0, 8.0, 0.2), np.arange(-4.0, 16.0, 0.2))
    places = np.stack([xs.ravel(), zs.ravel()], axis=1)
    # A street along z, 6 units wide, with streets to the left at z = 3 to 6 and 10 to 13, and to the right at 10 to 13.
    left = ((places[:, 1] > 3.0) & (places[:, 1] < 6.0)) | ((places[:, 1] > 10.0) & (places[:, 1] < 13.0))
    right = (places[:, 1] > 10.0) & (places[:, 1] < 13.0)
    built = ((places[:, 0] < -3.0) & ~left) | ((places[:, 0] > 3.0) & ~right)
    ground.add(Scan(places[built], np.ones(int(built.sum()), bool), places[~built]))
    side_streets = SideStreets(0.0, 0.0, 0.0)
    side_streets.add(ground, 0.0, 0.0, 0.0)
    first, second, only = side_streets.find(-1, 0), side_streets.find(-1, 1), side_streets.find(1, 0)
    assert first is not None
    assert 3.0 < first[1] < 5.5
    assert second is not None
    assert 10.0 < second[1] < 12.5
    assert only is not None
    assert 10.0 < only[1] < 12.5
    assert side_streets.find(1, 1) is None
    assert side_streets.find(0, 1) == min(second, only, key=lambda place: place[1])
    assert side_streets.find(0, 2) is None
    assert side_streets.nearest(-1, 0.0, 12.0) == second
