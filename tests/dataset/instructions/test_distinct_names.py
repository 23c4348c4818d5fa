"""Distinct names of an instruction's things: another, the next, an ordinal, several together."""

from dataclasses import replace

import pytest

from arramon_dataset.instructions.navigation.distinct_names import with_distinct_names
from arramon_dataset.instructions.navigation.groups import group_nearest_to
from arramon_dataset.instructions.navigation.landmark_names import counted_name
from arramon_dataset.instructions.visible_landmarks import Landmark
from arramon_dataset.randomness import seeded
from arramon_lang.coreference import mentions
from arramon_lang.meaning import Navigation, Rotate, Thing, Walk
from arramon_server.sim.geometry import Pose
from arramon_server.sim.labels import SegmentationLabel

MUG = Thing("mug", "red", "striped", identity="m")
RED, YELLOW = Thing("barrel", "red", identity="r"), Thing("barrel", "yellow", identity="y")
FULL = {"r": RED, "y": YELLOW, "b": Thing("bench", identity="b"), "c": Thing("bench", identity="c")}


def named(*things: Thing) -> list[Thing] | None:
    wording = with_distinct_names(
        Navigation(tuple(Walk("past", (thing,)) for thing in things), MUG), FULL, seeded("names")
    )
    return None if wording is None else [thing for thing in mentions(wording) if thing.identity != "m"]


def test_one_thing_keeps_its_name() -> None:
    assert named(RED, replace(RED, colour="")) == [RED, RED]


def test_two_of_a_kind_are_told_apart_by_colour_or_as_the_next() -> None:
    meaning = Navigation((Walk("past", (replace(RED, colour=""),)), Walk("past", (replace(YELLOW, colour=""),))), MUG)
    wording = [with_distinct_names(meaning, FULL, seeded("names", draw)) for draw in range(20)]
    names = {tuple(mentions(each))[:2] for each in wording if each is not None}
    assert names == {(RED, YELLOW), (RED, Thing("barrel", which="next"))}


def test_three_of_a_kind_are_told_apart_by_colour() -> None:
    green = Thing("barrel", "green", identity="g")
    full = {**FULL, "g": green}
    meaning = Navigation(tuple(Walk("past", (each,)) for each in (RED, YELLOW, green)), MUG)
    for draw in range(20):
        wording = with_distinct_names(meaning, full, seeded("names", draw))
        assert wording is not None
        assert tuple(mentions(wording))[:3] == (RED, YELLOW, green)


def test_two_that_look_alike_are_told_apart_by_a_word() -> None:
    wording = named(FULL["b"], FULL["c"], FULL["b"])
    assert wording is not None
    assert [thing.which in ("next", "another") for thing in wording] == [False, True, False]


def test_places_are_the_next_ones() -> None:
    corners = [Thing("corner", identity=identity) for identity in "de"]
    wording = with_distinct_names(
        Navigation(tuple(Rotate("left", "at", each) for each in corners), MUG), {}, seeded("places")
    )
    assert wording is not None
    assert [thing.which for thing in mentions(wording)][:2] == ["", "next"]


def test_what_cannot_be_told_apart_is_not_told() -> None:
    assert named(FULL["b"], replace(FULL["c"], which="second")) is None
    assert named(FULL["b"], Thing("bench", number="two", identity="b+c")) is None


def mark(identity: str, x: float, z: float) -> Landmark:
    return Landmark(SegmentationLabel("bench"), x, z, (0,), 0, identity)


FIRST, SECOND, ASIDE = mark("1", 1.0, 5.0), mark("2", -1.0, 9.0), mark("3", 9.0, 7.0)
VIEW = Pose(0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("own", "landmarks", "seen", "which"),
    [
        (FIRST, (FIRST, SECOND), (FIRST, SECOND), "first"),
        (SECOND, (FIRST, SECOND), (FIRST, SECOND), "second"),
        (SECOND, (FIRST, SECOND), (SECOND,), None),  # the first is not seen yet
        (SECOND, (FIRST, SECOND, ASIDE), (FIRST, SECOND, ASIDE), "second"),
        (ASIDE, (FIRST, SECOND, ASIDE), (FIRST, SECOND, ASIDE), None),
    ],
)
def test_ordinals(
    own: Landmark, landmarks: tuple[Landmark, ...], seen: tuple[Landmark, ...], which: str | None
) -> None:
    name = counted_name(own, landmarks, seen, VIEW)
    assert (None if name is None else name.which) == which


@pytest.mark.parametrize(
    ("landmarks", "number"),
    [
        ((FIRST, SECOND), "two"),
        ((FIRST, SECOND, mark("4", 0.0, 7.0)), "several"),
        ((FIRST,), None),
        ((FIRST, SECOND, mark("4", 0.0, 14.0)), None),  # one more, hardly apart
        ((FIRST, SECOND, replace(mark("4", 0.0, 14.0), glimpsed=None)), "two"),  # one is never visible
    ],
)
def test_groups(landmarks: tuple[Landmark, ...], number: str | None) -> None:
    group = group_nearest_to(FIRST, landmarks, landmarks, VIEW, until=3)
    assert (None if group is None else group.name.number) == number
