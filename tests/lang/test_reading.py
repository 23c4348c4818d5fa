"""Reading of instructions: generated texts back to their meaning, and human-written texts."""

import re
from contextlib import suppress
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from arramon_client.world import PHASES
from arramon_dataset.paraphrases.collection import paraphrases
from arramon_lang import CannotRead, load
from arramon_lang.coreference import first_mentions
from arramon_lang.meaning import Assembly, Face, Meaning, Navigation, Rotate, Thing, Walk, Where
from tests.lang import random_meanings

BENCH, CONE, BOOTH = Thing("bench"), Thing("cone", "blue"), Thing("phone_booth")
SILVER = Thing("bench", "silver")
MUG, BALL = Thing("mug", "red", "striped"), Thing("ball", "blue", "dotted")


def phase_of(meaning: Meaning) -> str:
    return "navigation" if isinstance(meaning, Navigation) else "assembly"


def near(thing: Thing, *landmarks: Thing, relation: str = "near") -> Thing:
    return Thing(thing.kind, thing.colour, thing.look, where=(Where(relation, landmarks),))


@given(st.integers(0, 2**32))
@settings(max_examples=120, deadline=None)
def test_written_texts_are_read_back_to_their_meaning(seed: int) -> None:
    random = Random(seed)
    for meaning in random_meanings.meanings(random, 1):
        text = load("en").write(meaning, random)
        read = load("en").read(text, phase_of(meaning))
        assert read == meaning, text
        assert first_mentions(read) == first_mentions(meaning), text


@pytest.mark.parametrize("language", ["en", "hi", "te"])
def test_parts_of_texts_in_any_order_are_read_or_refused(language: str) -> None:
    """Writers omit and mix up words: a reader may misunderstand them, and does not fail."""
    texts = [text for each in paraphrases() if each.language == language for text in (each.navigation, each.assembly)]
    texts = texts or [load(language).write(each, Random(0)) for each in random_meanings.meanings(Random(0), 1)]
    split = [re.sub("([,.;।])", r" \1", text).split() for text in texts]
    random, read = Random(7), 0
    for _ in range(150):
        parts = [random.choice(split) for _ in range(random.randint(1, 4))]
        starts = [random.randrange(len(part)) for part in parts]
        text = " ".join(" ".join(part[at : at + random.randint(1, 6)]) for part, at in zip(parts, starts, strict=True))
        for phase in PHASES:
            with suppress(CannotRead):
                load(language).read(text, phase)
                read += 1
    assert read > 100


PEOPLES: list[tuple[str, Meaning]] = [
    ("Turn left. Pick up the striped red mug.", Navigation((Rotate("left"),), MUG)),
    ("go foward and collect the dotted blue ball", Navigation((Walk("ahead"),), BALL)),
    (
        "Turn to face the metal bench. Walk to it and turn right. Grab the dottted blue ball behind it.",
        Navigation((Face(SILVER), Walk("to", (SILVER,)), Rotate("right")), near(BALL, SILVER, relation="behind")),
    ),
    (
        "Head past the bench and blue cone, then take the first left.",
        Navigation((Walk("past", (BENCH,)), Walk("past", (CONE,)), Rotate("left")), Thing("")),
    ),
    (
        "Walk until you see a dotted blue ball. Pick up the ball.",
        Navigation((Walk("until", (BALL,)),), BALL),
    ),
    (
        "Dont turn, walk past the 2 trees to the telephone booth & get the red mug with stripes, next to it!",
        Navigation((Walk("past", (Thing("tree", number="two"),)), Walk("to", (BOOTH,))), near(MUG, BOOTH)),
    ),
    ("Near the bench is a dotted blue ball.", Navigation((), near(BALL, BENCH))),
    (
        "Turn right and place it on top of the striped red mug.",
        Assembly(("right",), Thing(""), (Where("on_top_of", (MUG,)),)),
    ),
    (
        "The mug belongs infront of the dotted blue ball, against the wooden walll.",
        Assembly(
            (),
            Thing("mug"),
            (Where("in_front_of", (BALL,)), Where("against", (Thing("wall", look="wood"),))),
        ),
    ),
    (
        "Place the mug directly behind the ball dotted.",
        Assembly((), Thing("mug"), (Where("behind", (Thing("ball", look="dotted"),), True),)),
    ),
    (
        "Drop the ball directly in front of you.",
        Assembly((), Thing("ball"), (Where("in_front_of", (Thing("you"),), True),)),
    ),
    (
        "Turn right and place it against both the brick and wooden walls.",
        Assembly(
            ("right",),
            Thing(""),
            tuple(Where("against", (Thing("wall", look=look),)) for look in ("brick", "wood")),
        ),
    ),
    (
        "put the mug between the wooden wall and the dotted blue ball",
        Assembly((), Thing("mug"), (Where("between", (Thing("wall", look="wood"), BALL)),)),
    ),
]


@pytest.mark.parametrize(("text", "meaning"), PEOPLES, ids=[text for text, _ in PEOPLES])
def test_human_written_texts_are_read(text: str, meaning: Meaning) -> None:
    assert load("en").read(text, phase_of(meaning)) == meaning


@pytest.mark.parametrize(
    ("text", "phase"), [("", "navigation"), ("What a lovely day!", "navigation"), ("Hm.", "assembly")]
)
def test_text_without_any_meaning_is_an_error(text: str, phase: str) -> None:
    with pytest.raises(CannotRead, match=r"nothing understood in .*; expected steps or"):
        load("en").read(text, phase)


def test_unknown_phase_is_refused() -> None:
    with pytest.raises(ValueError, match="phase 'room'; expected navigation or assembly"):
        load("en").read("Turn left.", "room")


FREE: list[tuple[str, Meaning]] = [
    (
        "Swing round left past the bench, then right by the phone box. The mug: red, striped, over on your left.",
        Navigation(
            (Rotate("left"), Walk("past", (BENCH,)), Rotate("right", "at", BOOTH)),
            near(MUG, Thing("you"), relation="left_of"),
        ),
    ),
    (
        "Turn around, I think, and stroll past the grubby bench, phone booth and tree, all on your right.",
        Navigation(
            (
                Rotate("around"),
                *(Walk("past", (thing,), "right") for thing in (BENCH, BOOTH, Thing("tree"))),
            ),
            Thing(""),
        ),
    ),
    (
        "Over the crossing and over another, not quite to the phone box. Left there: striped red mug.",
        Navigation(
            (
                Walk("past", (Thing("zebra_crossing"),)),
                Walk("past", (Thing("zebra_crossing", which="another"),)),
                Rotate("left", "before", BOOTH),
            ),
            MUG,
        ),
    ),
    (
        "Far right corner, between brick and wood.",
        Assembly(
            (),
            Thing(""),
            (
                Where("near", (Thing("corner"),)),
                Where("against", (Thing("wall", look="brick"),)),
                Where("against", (Thing("wall", look="wood"),)),
            ),
        ),
    ),
]


@pytest.mark.parametrize(("text", "meaning"), FREE, ids=[text for text, _ in FREE])
def test_free_texts_are_read(text: str, meaning: Meaning) -> None:
    assert load("en").read(text, phase_of(meaning)) == meaning
