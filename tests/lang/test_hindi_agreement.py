"""Hindi's agreement: adjectives, participles and postpositions with every noun, in gender, number and case."""

import re
from collections.abc import Iterator
from random import Random

import pytest

from arramon_lang import load
from arramon_lang.meaning import Thing, Where
from arramon_lang.patterns import Pattern
from arramon_lang.writing.phrasing import Phraser
from tests.lang.hindi_forms import (
    COLOURS,
    FORMS,
    LOOKS,
    NOUNS,
    OWN_COLOURS,
    PARKED,
    POSTPOSITIONS,
    WHICHES,
    agreeing,
    before,
    nfc,
    nouns,
    voices,
)

PARTICIPLES = ["रखा|रखे|रखी", "पड़ा|पड़े|पड़ी", "रखा हुआ|रखे हुए|रखी हुई", "पड़ा हुआ|पड़े हुए|पड़ी हुई"]

DRAWS = 8
"""Number of texts to write for each noun."""


def unparked(text: str) -> str:
    """Return a text with single spaces, without the optional adjective of cars."""
    return " ".join(text.split()).replace(PARKED, "")


def things(kind: str) -> Iterator[tuple[Thing, list[str]]]:
    """Yield the kind with each possible adjective, and the adjective's expected wordings."""
    for colour, wordings in COLOURS.items():
        yield Thing(kind, colour=colour), OWN_COLOURS.get((kind, colour), wordings)
    for which, wordings in WHICHES.items():
        yield Thing(kind, which=which), wordings
    for (of, look), wordings in LOOKS.items():
        if of == kind or (of == "mug" and kind in ("ball", "hourglass", "tv", "book", "bowl", "bucket")):
            yield Thing(kind, look=look), wordings


@pytest.mark.parametrize("kind", NOUNS)
def test_adjectives_agree_with_every_noun_in_every_form(kind: str) -> None:
    grammar = load("hi").grammar
    for lexeme, gender, expected in nouns(kind):
        for thing, wordings in things(kind):
            phrasers = [Phraser(grammar, Random(seed), voice) for seed in range(2) for voice in voices()]
            fills = [phraser.thing(thing, lexeme, (), top=False) for phraser in phrasers]
            for (number, case), form in zip(FORMS, expected, strict=True):
                written = {unparked(fill({"number": number, "case": case})) for fill in fills}
                words = agreeing(wordings, gender, number, case)
                assert written <= {before(word, form) for word in words}
                assert all(any(f" {word} " in f" {text} " for text in written) for word in words)


@pytest.mark.parametrize("relation", POSTPOSITIONS)
def test_nouns_and_adjectives_are_oblique_before_postpositions(relation: str) -> None:
    seen = set()
    for kind in NOUNS:
        for lexeme, gender, expected in nouns(kind):
            for number, (thing, wordings) in enumerate(things(kind)):
                voice = voices()[number % 2]
                phraser = Phraser(load("hi").grammar, Random(number), voice)
                heads = {before(word, expected[1]) for word in agreeing(wordings, gender, "singular", "oblique")}
                fillers = {"thing": phraser.thing(thing, lexeme, (), top=False)}
                for pattern in (
                    each for each in phraser.grammar.where[relation] if each.weight and "{other" not in each.text
                ):
                    text = unparked(phraser.render(pattern, fillers, phraser.features))
                    (head,) = (head for head in heads if text.startswith(f"{head} "))
                    seen.add(text.removeprefix(f"{head} "))
    assert seen == {nfc(each) for each in POSTPOSITIONS[relation]}


@pytest.mark.parametrize("kind", NOUNS)
def test_two_objects_of_one_kind_are_plural(kind: str) -> None:
    plurals = {forms[3] for _, _, forms in nouns(kind)}
    for seed in range(DRAWS):
        wheres = (Where("between", (Thing(kind), Thing(kind))),)
        text = unparked(Phraser(load("hi").grammar, Random(seed)).wheres(wheres, top=True))
        assert re.search(r"(^| (के|की) )(दो|दोनों) ", text)
        assert any(
            f" {plural} के बीच" in text or before("दो", plural) in text or before("दोनों", plural) in text
            for plural in plurals
        ), text


@pytest.mark.parametrize("kind", NOUNS)
def test_participles_agree_with_their_noun(kind: str) -> None:
    where = (Where("near", (Thing("tree"),)),)
    for lexeme, gender, expected in nouns(kind):
        for (number, case), form in zip(FORMS, expected, strict=True):
            for attached, wordings in (("attached", PARTICIPLES), ("nested", ["वाला|वाले|वाली"])):
                words = agreeing(wordings, gender, number, case)
                allowed = {f"{word} {form}" for word in words}
                for seed in range(4):
                    phraser = Phraser(load("hi").grammar, Random(seed))
                    patterns: tuple[Pattern, ...] = getattr(phraser.grammar, attached)
                    fill = phraser.thing(Thing(kind, where=where), lexeme, patterns, top=True)
                    text = unparked(fill({"number": number, "case": case}))
                    assert any(text.endswith(f" {each}") for each in allowed), text


@pytest.mark.parametrize(
    ("thing", "words"),
    [
        (Thing("car", "blue"), ["", "नीली"]),
        (Thing("car", "blue", which="another"), ["एक और", "नीली"]),
        (Thing("car", "red", which="second"), ["दूसरी", "लाल"]),
    ],
)
def test_a_parked_car_has_its_colour_beside_its_noun(thing: Thing, words: list[str]) -> None:
    first, colour = words
    expected = {f"{first} {parked}{colour} {noun}".strip() for parked in ("", PARKED) for noun in ("कार", "गाड़ी")}
    written = set()
    for seed in range(60):
        phraser = Phraser(load("hi").grammar, Random(seed))
        written.add(" ".join(phraser.thing(thing, phraser.noun(thing), (), top=True)({}).split()))
    assert {nfc(each) for each in expected} == {text for text in written if " रंग " not in text}
