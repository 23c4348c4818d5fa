"""Detection of a false reference among true texts."""

from pathlib import Path

from arramon_lang import load
from benchmarks.instructions.mentions import mentions
from benchmarks.instructions.references import StreetObject, identifies_target
from tests import tiny
from tests.benchmarks.command import printed


def test_a_false_text_is_shown(tmp_path: Path) -> None:
    """Both turns have the first one's text, and in the second there is no red mug."""
    tiny.write(tmp_path, "val_seen", 1)
    tiny.write(tmp_path, "val_unseen", 1)
    lines = printed("benchmarks.instructions.references", tmp_path, "--split", "val_seen", "--show", 1)
    assert lines[0] == "  0 en: Go on to the striped red mug. (there are no such things)"
    assert lines[1].startswith("val_seen section 1 en: 2 texts, 2 things, 1 texts false;")
    assert len(lines) == 2


def test_so_that_refers_to_nothing_mentioned_before() -> None:
    (bench,) = mentions("Turn so that the bench is in front of you.", "en")
    assert bench.marker == ""
    (bench,) = mentions("Go past that bench.", "en")
    assert bench.marker == "same"


def test_that_car_is_the_latest_one() -> None:
    """The target lies beside the second car, its look-alike beside none."""
    things = [StreetObject("car", "blue", "", 0.0, 0.0, 0, 1.0), StreetObject("car", "yellow", "", 0.0, 20.0, 9, 1.0)]
    mugs = [{"type": "mug", "position": (1.0, 0.0, z)} for z in (20.0, 40.0)]
    for text, expected in (
        ("Pass the blue car. Turn left at the next car. Go to the bench. Pick up the mug behind that car.", True),
        ("Pass the blue car. Turn left. Pick up the mug behind that car.", False),
    ):
        assert identifies_target(list(mentions(text, "en")), {"street": mugs}, things) is expected


def test_that_car_in_hindi_is_the_one_before_unless_a_clause_describes_it() -> None:
    of = {text: [each.marker for each in mentions(text, "hi") if each.kind == "car"] for text in HINDI_CARS}
    assert of == HINDI_CARS


HINDI_CARS = {
    "नीली कार के पास से निकलिए और उस कार के पीछे जो भूरी रेतघड़ी रखी है, उसे उठाइए।": ["", "same"],
    "उस कार तक जाओ, जो बाईं ओर है।": [""],
    "उस कार की ओर चलो, जो बाईं तरफ़ है।": [""],
}
"""Texts, with the markers of the cars that they mention."""


def test_texts_in_another_script_are_unread_and_those_with_loans_are_read() -> None:
    for text, is_read in (
        ("kiosk ke paas se niklo aur laal mug utha lo", False),
        ("खोखे के पास से निकलो और लाल मग उठा लो", True),
        ("खोखे (kiosk) के पास से निकलो और लाल मग उठा लो", True),
    ):
        assert load("hi").is_in_own_script(text) is is_read
    assert load("en").is_in_own_script("Pick up the mug.")


def test_trash_bags_are_a_pile_of_them() -> None:
    (bags,) = mentions("past trash bags", "en")
    assert bags.kind == "bags"
