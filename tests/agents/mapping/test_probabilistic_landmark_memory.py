"""Memories of landmarks and of the room with attribute probabilities."""

import numpy as np
import pytest

from arramon_agents.mapping.probabilistic_landmark_memory import ProbabilisticLandmarkMemory
from arramon_agents.mapping.probabilistic_room_memory import ProbabilisticRoomMemory
from arramon_agents.perception.eyes.predicted_segmentation import LABELS
from arramon_agents.perception.scan import FrameScanner
from arramon_lang.cell_grading import RoomObject
from arramon_lang.meaning import Thing
from tests.agents.perception.eyes.test_grid import named

SMALL, LARGE = (slice(100, 105), slice(40, 45)), (slice(100, 130), slice(40, 70))
FORWARD, RIGHT = (0.0, 0.0, 0.0), (0.0, 0.0, 1.5707963)


def test_a_large_view_outweighs_several_small_ones() -> None:
    memory = ProbabilisticLandmarkMemory(LABELS)
    for _ in range(3):
        memory.add_things([named("ball", "red", "dotted", *SMALL, ahead=3.0)], FORWARD)
    memory.add_things([named("mug", "blue", "striped", *LARGE, ahead=3.0)], FORWARD)
    (mark,) = memory.matching(Thing("mug", "blue", "striped"))
    assert (mark.x, mark.z) == pytest.approx((0.0, 3.0))
    assert memory.matching(Thing("ball")) == []
    assert memory.matching(Thing("", "blue"))[0] is mark


@pytest.mark.parametrize(("sums", "kind"), [(True, "ball"), (False, "mug")])
def test_views_are_summed_or_the_largest_one_counts(sums: bool, kind: str) -> None:
    memory = ProbabilisticLandmarkMemory(LABELS, sums=sums)
    larger = slice(SMALL[0].start, SMALL[0].stop + 2), SMALL[1]
    for name, size, ahead in (("mug", larger, 3.0), ("ball", SMALL, 2.5), ("ball", SMALL, 3.0)):
        memory.add_things([named(name, "red", "dotted", *size, ahead=ahead)], FORWARD)
    (mark,) = memory.matching(Thing("", "red"))
    assert mark.label.kind == kind
    assert mark.z == pytest.approx(2.5)  # The nearest view tells the place in either case.


def test_things_are_kept_by_place_in_the_agents_own_frame() -> None:
    memory = ProbabilisticLandmarkMemory(LABELS)
    for pose in (FORWARD, RIGHT):
        memory.add_things([named("cone", "red", "", *LARGE, ahead=4.0)], pose)
    places = [(mark.x, mark.z) for mark in memory.matching(Thing("cone"))]
    assert places == [pytest.approx((0.0, 4.0), abs=1e-5), pytest.approx((4.0, 0.0), abs=1e-5)]
    memory.forget()
    assert memory.matching(Thing("cone")) == []


def test_the_rooms_things_stand_in_cells() -> None:
    room = ProbabilisticRoomMemory(LABELS)
    room.add_things([named("mug", "blue", "striped", *LARGE, ahead=2.8)], (2, 0), 0.0)
    room.add_things([named("mug", "blue", "striped", *LARGE, ahead=1.3)], (2, 0), 90.0)
    room.add_things([named("cone", "red", "", *LARGE, ahead=1.3)], (2, 0), 270.0)
    room.add_things([named("mug", "blue", "striped", *LARGE, ahead=9.0)], (2, 0), 0.0)
    assert room.room().things == (
        RoomObject("mug", "blue", "striped", 2, 2),
        RoomObject("mug", "blue", "striped", 3, 0),
    )


def test_sightings_that_the_memory_ignores_are_not_computed() -> None:
    memory, random = ProbabilisticLandmarkMemory(LABELS), np.random.default_rng(4)
    depth = random.uniform(1.0, 9.0, (112, 112)).astype(np.float32)
    segmentation = random.integers(len(LABELS), size=(112, 112)).astype(np.uint16)
    pose = (1.0, -2.0, 0.4)
    every = FrameScanner(LABELS).sightings(depth, segmentation, pose)
    assert memory.used_labels is not None
    used = [seen for seen in every if seen.label in memory.used_labels]
    assert FrameScanner(LABELS, memory.used_labels).sightings(depth, segmentation, pose) == used
    assert 0 < len(used) < len(every)
