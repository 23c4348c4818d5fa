"""What agents that keep a map note: what they read, and what they are about to do."""

import pytest

from arramon_agents.mapping.notes import outline, place, reading
from arramon_client.notes import note_fault, note_text
from arramon_lang.meaning import Assembly, Face, Meaning, Navigation, Rotate, Thing, Walk, Where

MUG = Thing("mug", "red", "striped")


@pytest.mark.parametrize(
    ("meaning", "expected"),
    [
        (
            Navigation((Rotate("left"), Walk("past", (Thing("bench", which="second"),), side="left"), Face(MUG)), MUG),
            {
                "steps": [
                    {"do": "rotate", "direction": "left"},
                    {"do": "walk", "way": "past", "things": [{"kind": "bench", "which": "second"}], "side": "left"},
                    {"do": "face", "thing": {"kind": "mug", "colour": "red", "look": "striped"}},
                ],
                "target": {"kind": "mug", "colour": "red", "look": "striped"},
            },
        ),
        (
            Assembly(("right",), Thing("", "red"), (Where("behind", (Thing("tv"),), exactly=True),)),
            {
                "turns": ["right"],
                "thing": {"colour": "red"},
                "where": [{"relation": "behind", "things": [{"kind": "tv"}], "exactly": True}],
            },
        ),
    ],
)
def test_only_what_is_stated_is_noted(meaning: Meaning, expected: object) -> None:
    assert outline(meaning) == expected
    assert reading(meaning) == {"read": expected}


@pytest.mark.parametrize(
    ("meaning", "expected"),
    [
        (Navigation((Walk("past", (MUG,)),) * 40, MUG), {"steps": 40, "target": {"kind": "mug"}}),
        (Assembly((), MUG, (Where("behind", (MUG,)),) * 40), {"turns": 0, "thing": {"kind": "mug"}}),
    ],
)
def test_a_very_long_meaning_is_noted_in_short(meaning: Meaning, expected: object) -> None:
    assert note_fault(note_text({"read": outline(meaning)}))
    assert reading(meaning) == {"read": expected}


def test_places_are_rounded() -> None:
    assert place(1.26, -0.04) == [1.3, -0.0]
