"""Agreement of a reading with a written meaning: what counts as the same, and what does not."""

from typing import Any

import pytest

from lang.meaning import Assembly, Face, Navigation, Rotate, Thing, Walk, Where
from server.dataset.paraphrases.agreement import assembly_agrees, name_said, navigation_agrees

READ = Navigation(
    (
        Rotate("left", "at", Thing("mailbox")),
        Walk("past", (Thing("barrier", "white"),), "right"),
        Walk("ahead"),
        Walk("to", (Thing("intersection"),)),
        Face(Thing("car", "red")),
    ),
    Thing("tv", "red", "dotted", where=(Where("near", (Thing("tree"),)),)),
)
SAID: dict[str, Any] = {
    "steps": [
        ["turn", "left", "at", "mailbox"],
        ["walk", "past", "white barrier", "right"],
        ["walk", "until", "crossing"],
        ["face", "red car"],
    ],
    "target": {"thing": "dotted red tv", "where": [["near", "tree"]]},
}


def test_a_reading_with_the_same_steps_agrees() -> None:
    assert navigation_agrees(READ, SAID)


@pytest.mark.parametrize(
    "change",
    [
        {"steps": SAID["steps"][:-1]},
        {"steps": [["turn", "right", "at", "mailbox"], *SAID["steps"][1:]]},
        {"steps": [["turn", "left", "after", "mailbox"], *SAID["steps"][1:]]},
        {"steps": [["turn", "left"], *SAID["steps"][1:]]},
        {"steps": [SAID["steps"][0], ["walk", "past", "white barrier", "left"], *SAID["steps"][2:]]},
        {"steps": [SAID["steps"][0], ["walk", "past", "red barrier", "right"], *SAID["steps"][2:]]},
        {"steps": [SAID["steps"][0], ["walk", "towards", "white barrier"], *SAID["steps"][2:]]},
        {"steps": [SAID["steps"][1], SAID["steps"][0], *SAID["steps"][2:]]},
        {"target": {"thing": "dotted blue tv", "where": [["near", "tree"]]}},
        {"target": {"thing": "striped red tv", "where": [["near", "tree"]]}},
        {"target": {"thing": "dotted red tv", "where": []}},
        {"target": {"thing": "dotted red tv", "where": [["behind", "tree"]]}},
    ],
)
def test_a_reading_with_another_step_or_target_does_not_agree(change: dict[str, Any]) -> None:
    assert not navigation_agrees(READ, {**SAID, **change})


def test_of_two_things_the_order_does_not_matter() -> None:
    read = Navigation((Walk("between", (Thing("bin"), Thing("cone", "blue"))),), Thing("mug", "red"))
    said = {"steps": [["walk", "between", ["blue cone", "bin"]]], "target": {"thing": "red mug", "where": []}}
    assert navigation_agrees(read, said)


PLACED = Assembly(
    ("right",), Thing("mug", "red"), (Where("behind", (Thing("tv"),)), Where("against", (Thing("wall", "", "brick"),)))
)


@pytest.mark.parametrize(
    ("room", "agrees"),
    [
        ({"turns": ["right"], "thing": "red mug", "where": [["against", "brick wall"], ["behind", "tv"]]}, True),
        ({"turns": ["right"], "thing": "", "where": [["behind", "tv"], ["against", "brick wall"]]}, True),
        ({"turns": [], "thing": "red mug", "where": [["behind", "tv"], ["against", "brick wall"]]}, False),
        ({"turns": ["right"], "thing": "blue mug", "where": [["behind", "tv"], ["against", "brick wall"]]}, False),
        ({"turns": ["right"], "thing": "red mug", "where": [["behind", "tv"]]}, False),
        ({"turns": ["right"], "thing": "red mug", "where": [["behind", "tv"], ["against", "wood wall"]]}, False),
    ],
)
def test_an_assembly_agrees_by_turns_object_and_relations(room: dict[str, Any], agrees: bool) -> None:
    assert assembly_agrees(PLACED, {"room": room}) is agrees


@pytest.mark.parametrize(
    ("words", "name"),
    [
        ("dotted red tv", ("tv", "red", "dotted")),
        ("second white barrier", ("barrier", "white", "")),
        ("star black banner", ("banner", "black", "star")),
        ("crossroads", ("intersection", "", "")),
        ("two cones", ("cone", "", "")),
        ("golden barrel", ("barrel", "gold", "")),
        ("zebra crossing", ("zebra_crossing", "", "")),
        ("brick building", ("building", "", "brick")),
        ("hourglass", ("hourglass", "", "")),
    ],
)
def test_a_name_in_plain_words_has_kind_colour_and_look(words: str, name: tuple[str, str, str]) -> None:
    assert name_said(words) == name
