"""Names of things: canonical forms, and which names can denote the same thing."""

import pytest

from arramon_lang.meaning import Thing
from benchmarks.instructions.names import ComparedName, parsed_name, written_name


@pytest.mark.parametrize(
    ("words", "thing"),
    [
        ("dotted red tv", Thing("tv", "red", "dotted")),
        ("second white barrier", Thing("barrier", "white", which="second")),
        ("star black banner", Thing("banner", "black", "star")),
        ("crossroads", Thing("intersection")),
        ("t_junction", Thing("intersection", arms=3)),
        ("two cones", Thing("cone", number="two")),
        ("golden barrel", Thing("barrel", "gold")),
        ("concrete barrier", Thing("barrier", "concrete")),
        ("zebra crossing", Thing("zebra_crossing")),
        ("brick building", Thing("building", look="brick")),
        ("hourglass", Thing("hourglass")),
        ("blue phone_booth", Thing("phone_booth")),
        ("hotel building", Thing("shop_sign", look="hotel")),
        ("white building corner", Thing("building_corner", look="white")),
        ("several benches", Thing("bench", number="several")),
    ],
)
def test_words_of_a_written_meaning_and_a_reading_of_them_are_one_name(words: str, thing: Thing) -> None:
    assert written_name(words) == parsed_name(thing)


@pytest.mark.parametrize(
    ("one", "other", "fit"),
    [
        ("white black mug", "white mug", True),
        ("red triangle banner", "triangle banner", True),
        ("blue bank building", "bank building", True),
        ("red cone", "cone", False),
        ("red cone", "blue cone", False),
        ("red cone", "red barrel", False),
        ("star banner", "diamond banner", False),
        ("second cone", "third cone", False),
        ("another cone", "second cone", True),
    ],
)
def test_names_fit_by_kind_and_what_they_say(one: str, other: str, fit: bool) -> None:
    assert written_name(one).fits(written_name(other)) is fit
    assert written_name(other).fits(written_name(one)) is fit


def test_the_kind_is_the_last_word() -> None:
    assert written_name("orange-white barrier") == ComparedName("barrier", frozenset({"white"}))
