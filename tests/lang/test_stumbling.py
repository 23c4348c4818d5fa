"""Kinds of English at which a native reader stumbled, and that are no longer written."""

import re
from random import Random

import pytest

from arramon_lang import load
from arramon_lang.meaning import Assembly, Face, Meaning, Navigation, Rotate, Step, Thing, Walk, Where

ENGLISH = load("en")
MUG = Thing("mug", "red", "striped", identity="9")
KIOSK, CONE = Thing("kiosk", "blue", identity="1"), Thing("cone", "red", identity="2")
CAR, TREE = Thing("car", "white", identity="3"), Thing("tree", identity="4")


def written(meaning: Meaning, count: int = 40) -> list[str]:
    return [ENGLISH.write(meaning, Random(seed)) for seed in range(count)]


@pytest.mark.parametrize(
    ("steps", "named"),
    [
        ((Face(KIOSK), Walk("past", (KIOSK,))), "blue"),
        ((Face(KIOSK), Walk("past", (KIOSK,)), Walk("past", (CONE,))), "blue"),
        ((Walk("until", (KIOSK,), straight=False), Rotate("left", "at", KIOSK)), "blue"),
        ((Face(KIOSK), Rotate("left", "at", KIOSK)), "blue"),
        ((Face(KIOSK), Rotate("left", "before", KIOSK)), "blue"),
        ((Rotate("left"), Face(KIOSK), Walk("to", (KIOSK,))), "blue"),
    ],
)
def test_the_next_clause_does_not_name_a_thing_again(steps: tuple[Step, ...], named: str) -> None:
    meaning = Navigation(steps, MUG)
    texts = written(meaning)
    assert not [text for text in texts if len(re.findall(rf"\b{named}\b", text)) > 1]
    assert {ENGLISH.read(text, "navigation") for text in texts} == {meaning}


@pytest.mark.parametrize(
    ("steps", "never"),
    [
        (
            (Face(KIOSK), Rotate("left", "before", KIOSK)),
            r"(kiosk|booth|stand)\W+(and |then )*(turn|take|make|before)\b",
        ),
        ((Rotate("around"), Face(CONE)), r"turn around(\.|,| and| then)+ (\w+ )?turn "),
        ((Rotate("left"), Face(CONE)), r"left facing"),
        ((Face(CONE), Walk("past", (TREE,))), r"cone and pass"),
        ((Rotate("left"), Walk("past", (CONE,)), Walk("past", (TREE,))), r"(when|once) (you get )?there"),
        ((Walk("to", (KIOSK,)),), r"^you (will|should)"),
        ((Walk("ahead"), Rotate("left"), Walk("ahead")), r"go ahead( and|,|\.|$)"),
        ((Walk("past", (TREE,)),), r"\bpass [^.,]* to (pick|collect|grab|get|take|fetch)"),
    ],
)
def test_faulty_wordings_are_not_written(steps: tuple[Step, ...], never: str) -> None:
    texts = written(Navigation(steps, MUG))
    assert not [text for text in texts if re.search(never, text, re.IGNORECASE)]


def test_a_place_is_not_torn_from_its_verb() -> None:
    beside = Assembly((), Thing("tv"), (Where("behind", (Thing("tv", "white", "striped"),)),))
    on = Assembly((), Thing("tv"), (Where("on_top_of", (Thing("mug", "brown", "striped"),)),))
    torn = re.compile(r"\b(set|put|lay|place) down the\b[^.,]* behind\b", re.IGNORECASE)
    assert not [text for text in written(beside) if torn.search(text)]
    stacked = re.compile(r"\b(place|put|set) [^.]*\bstacked on\b", re.IGNORECASE)
    assert not [text for text in written(on) if stacked.search(text)]
    assert not [text for text in written(on, 80) if re.search(r"\blay\b|goes atop", text, re.IGNORECASE)]


def test_a_target_beside_the_last_thing_is_beside_it() -> None:
    target = Thing("mug", "red", "striped", where=(Where("near", (KIOSK,)),), identity="9")
    for text in written(Navigation((Rotate("left"), Walk("to", (KIOSK,))), target)):
        assert len(re.findall(r"\bblue\b", text)) == 1, text


@pytest.mark.parametrize(
    ("kind", "never"),
    [
        ("zebra_crossing", "zebra"), ("hydrant", "fireplug|fire plug"), ("tyre_stack", "tyre|tire stack"),
        ("speed_sign", "post|board"), ("planter", "tub|flower box"), ("t_junction", "junction"), ("cone", "road cone"),
        ("kiosk", "street kiosk|stall"), ("awning", "shop"), ("banner", "pennant"), ("mailbox", "letter|post ?box"),
        ("phone_booth", r"phone box"), ("bin", "rubbish|litter|dust"), ("dumpster", "skip|refuse"),
    ],
)  # fmt: skip
def test_no_british_or_invented_names(kind: str, never: str) -> None:
    colour = "red" if kind in ("cone", "kiosk", "awning", "banner") else ""
    texts = written(Navigation((Walk("past", (Thing(kind, colour, identity="1"),)),), MUG), 60)
    assert not [text for text in texts if re.search(rf"\b({never})\b", text, re.IGNORECASE)]


def test_a_car_may_be_parked_but_nobody_says_so() -> None:
    meaning = Navigation((Walk("past", (CAR,)),), MUG)
    assert not [text for text in written(meaning, 80) if "parked" in text.lower()]
    assert ENGLISH.read("Go past the parked white car. Pick up the striped red mug.", "navigation") == meaning


def test_clauses_that_read_as_a_part_of_the_one_before() -> None:
    steps = (Walk("past", (TREE,)), Rotate("left", "before", KIOSK), Walk("past", (CONE,)), Walk("to", (CAR,)))
    for text in written(Navigation(steps, MUG), 80):
        assert not re.search(r"until you pass [^.,]* and turn", text, re.IGNORECASE), text
        assert len(re.findall(r"\bcontinu", text, re.IGNORECASE)) < 3, text
        assert not re.search(
            r"\ba (\w+ )*tree and (?!an? |the |(turn|go|head|bear|veer|take|make) )", text, re.IGNORECASE
        ), text


def test_the_room() -> None:
    book = Thing("book", "red", "dotted", identity="1")
    walls = tuple(Where("against", (Thing("wall", look=look),)) for look in ("brick", "wood"))
    corner = Assembly((), MUG, walls)
    texts = written(corner)
    assert any(re.search(r"where the .* meet", text) for text in texts)
    assert {ENGLISH.read(text, "assembly") for text in texts} == {corner}
    beside = Assembly((), MUG, (Where("diagonal_to", (book,)), Where("left_of", (Thing("you"),))))
    texts = written(beside)
    assert not [text for text in texts if re.search(r"on your left and|to your left and", text)]
    assert any("book, on your left" in text for text in texts)
