"""Alignment of instructions to walks."""

import pytest

from arramon_dataset.release.landmarks.alignment import align
from arramon_dataset.release.landmarks.mentions import Event
from arramon_dataset.release.landmarks.recovery import LandmarkMap
from tests.dataset.release.landmarks.walks import path_along

LEFT, RIGHT = Event(direction="left"), Event(direction="right")
BIN = Event(kind="bin", manner="past")
PATH = path_along((0, 0), (0, 10), (10, 10), (10, 20))
"""North, to the right at step 10, to the left at step 20."""


@pytest.mark.parametrize(
    ("events", "places"),
    [
        ((RIGHT, LEFT), (10, 20)),
        ((RIGHT,), (10,)),
        ((LEFT,), (20,)),
        ((RIGHT, Event(kind="bin", manner="at", tied=True), LEFT), (10, 10, 20)),
    ],
)
def test_turns_are_found_where_the_walk_turns(events: tuple[Event, ...], places: tuple[int, ...]) -> None:
    found = align(events, PATH, LandmarkMap().fit)
    assert all(abs(at - expected) <= 2 for at, expected in zip(found.best, places, strict=True)), found.best
    assert found.posterior.sum(axis=1) == pytest.approx([1.0] * len(events))


def test_a_known_landmark_holds_its_mention() -> None:
    near_start, near_end = ([(place[0] + 1.7, place[1], 0.9, "")] for place in (PATH.places[3], PATH.places[27]))
    for places, low, high in ((near_start, 0, 6), (near_end, 24, 30)):
        (at,) = align([BIN], PATH, LandmarkMap.of({"bin": places}).fit).best
        assert low <= at <= high


def test_what_the_target_is_beside_is_at_the_end() -> None:
    found = align([RIGHT, Event(kind="bin", manner="target", relation="near")], PATH, LandmarkMap().fit)
    assert found.best[-1] == len(PATH.places) - 1
