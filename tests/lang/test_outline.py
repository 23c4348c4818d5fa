"""Outlines of navigation instructions."""

import pytest

from arramon_lang import load

TEXTS = [
    (
        "en",
        "Turn right to face the silver dumpster. Walk past it and turn left at the bench. "
        "Pick up the dotted green mug behind the blue cone.",
        [
            "right", "faced dumpster silver", "past dumpster silver", "left", "at bench+", "target cone blue behind",
        ],
    ),
    ("en", "There was a hydrant once. Go past the mailbox on your left.", ["past hydrant", "past mailbox left"]),
    (
        "hi",
        "बाएँ मुड़ें और फ़ायर हाइड्रेंट तक सीधे चलें। बेंच के पास रखा धारीदार लाल मग उठा लें।",
        ["left", "to hydrant", "target bench near"],
    ),
    ("en", "hello world", []),
]  # fmt: skip


@pytest.mark.parametrize(("code", "text", "expected"), TEXTS)
def test_turns_and_things_come_in_the_order_of_the_text(code: str, text: str, expected: list[str]) -> None:
    entries = []
    for said in load(code).outline(text):
        thing = said.thing
        words = (
            (said.direction,) if thing is None else (said.manner, thing.kind, thing.colour, said.relation, said.side)
        )
        entries.append(" ".join(filter(None, words)) + "+" * said.tied)
    assert entries == expected


def test_a_thing_named_twice_has_one_identity() -> None:
    things = [said.thing for said in load("en").outline("Go to the red barrel. Walk past the barrel. Go to the bench.")]
    first, again, other = (thing.identity for thing in things if thing is not None)
    assert first == again != other
