"""What a demanding reader of American English stumbled over is read, and no longer written."""

import re
from dataclasses import replace
from random import Random

import pytest

from arramon_lang import load
from arramon_lang.meaning import Assembly, Face, Meaning, Navigation, Rotate, Thing, Walk, Where

ENGLISH = load("en")
MUG, CONE = Thing("mug", "red", "striped", identity="mug"), Thing("cone", "red", identity="cone")


def written(meaning: Meaning, count: int = 60) -> list[str]:
    return [ENGLISH.write(meaning, Random(seed)) for seed in range(count)]


@pytest.mark.parametrize(
    ("kind", "never"),
    [
        ("dumpster", "waste|industrial"), ("barrel", "golden|fuel|drum"), ("phone_booth", "public phone"),
        ("mailbox", "drop|collection"), ("banner", "hanging flag|vertical"), ("stop_sign", "red stop"),
        ("barrier", "roadblock"), ("awning", "overhang"), ("cone", "caution|warning"), ("intersection", "junction"),
        ("bags", "bunch|cluster"), ("car", "vehicle"), ("tree", "shade|street tree"),
    ],
)  # fmt: skip
def test_everyday_names(kind: str, never: str) -> None:
    colour = {"barrel": "gold", "cone": "red", "awning": "red", "banner": "red", "car": "red"}.get(kind, "")
    texts = written(Navigation((Walk("past", (Thing(kind, colour, identity="1"),)),), MUG))
    assert not [text for text in texts if re.search(rf"\b({never})\b", text, re.IGNORECASE)]


def test_only_a_wall_is_what_is_closest() -> None:
    wall, ball = Thing("wall", look="brick"), Thing("ball", "blue", "striped")
    by_wall = Assembly((), MUG, (Where("behind", (ball,)), Where("near", (wall,))))
    assert any("closest to the" in text for text in written(by_wall))
    texts = [
        *written(Assembly((), MUG, (Where("near", (ball,)),))),
        *written(Navigation((), replace(MUG, where=(Where("near", (CONE,)),)))),
    ]
    assert not [text for text in texts if "closest" in text]


def test_one_who_has_just_turned_walks_to_it() -> None:
    meaning = Navigation((Rotate("left"), Face(CONE), Walk("to", (CONE,)), Rotate("right")), MUG)
    texts = written(meaning)
    assert any(re.search(r"\b(go|walk) to it\b", text, re.IGNORECASE) for text in texts)
    odd = r"\b(keep(?! an eye out)|continue|proceed|move until|go until|start walking)\b"
    assert not [text for text in texts if re.search(odd, text, re.IGNORECASE)]
    assert {ENGLISH.read(text, "navigation") for text in texts} == {meaning}


def test_places_in_the_room() -> None:
    ball = Thing("ball", "blue", "striped", identity="ball")
    corner = Assembly((), MUG, tuple(Where("against", (Thing("wall", look=look),)) for look in ("brick", "wood")))
    for meaning, usual in (
        (corner, "meet"),
        (Assembly((), MUG, (Where("diagonal_to", (ball,)), Where("left_of", (Thing("you"),)))), "diagonally across"),
    ):
        texts = written(meaning)
        assert any(usual in text for text in texts)
        odd = r"touching|adjacent|quarter turn|in contact|\ba (striped|blue)"
        assert not [text for text in texts if re.search(odd, text, re.IGNORECASE)]
        assert {ENGLISH.read(text, "assembly") for text in texts} == {meaning}


def test_a_target_is_not_to_be_carried_to_the_right() -> None:
    beside = Thing("tv", "blue", "striped", where=(Where("right_of", (CONE,)),), identity="tv")
    texts = written(Navigation((Rotate("left"),), beside))
    assert not [text for text in texts if re.search(r"\b(take|get) the [^.]* to the right of", text, re.IGNORECASE)]
