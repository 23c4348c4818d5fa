"""Telugu: texts are read back, agree in case and number, keep to one register, and have no word twice in a row."""

import re
from random import Random

import pytest

from arramon_dataset.language_check import repeats
from arramon_lang.language import load
from arramon_lang.meaning import Assembly, Meaning, Navigation, Rotate, Thing, Walk, Where
from arramon_lang.quality import check
from tests.lang import random_meanings

TELUGU = load("te")
BENCH, TREE, BUCKET = (Thing(kind, identity=kind) for kind in ("bench", "tree", "bucket"))
MUG = Thing("mug", "red", "dotted", identity="m")


def texts_of(meaning: Meaning, count: int = 30) -> set[str]:
    return {TELUGU.normalise(TELUGU.write(meaning, Random(seed))) for seed in range(count)}


def test_random_meanings_are_read_back() -> None:
    for number, meaning in enumerate(random_meanings.meanings(Random(31), 40)):
        phase = "navigation" if isinstance(meaning, Navigation) else "assembly"
        text = TELUGU.write(meaning, Random(number))
        assert TELUGU.read(text, phase) == meaning, text
        assert not list(repeats(TELUGU, text)), text


@pytest.mark.parametrize(
    ("meaning", "pattern"),
    [
        (Navigation((Walk("past", (TREE,)),), MUG), "చెట్టు(ను)? దాట|చెట్టు పక్క నుంచి|చెట్టు ముందు నుంచి"),
        (Navigation((Rotate("left", "before", TREE),), MUG), "చెట్టుకు ముందే|చెట్టు రాకముందే|చెట్టు దగ్గరికి చేరకముందే"),
        (Navigation((Walk("between", (TREE, Thing("car", identity="c"))),), MUG), "చెట్టుకు, కారుకు మధ్య"),
        (Navigation((Walk("to", (Thing("tree", number="two"),)),), MUG), "రెండు (పచ్చని )?(చెట్ల |చెట్లు వచ్చేవరకు)"),
        (Assembly((), Thing("book"), (Where("left_of", (BUCKET,)),)), "పుస్తకాన్ని|బుక్ను"),
        (
            Assembly((), Thing("book"), (Where("left_of", (BUCKET,)),)),
            "బకెట్కు (ఎడమవైపు|ఎడమవైపున|ఎడమ పక్కన)",
        ),
    ],
)
def test_the_noun_bears_the_case_that_its_place_asks_for(meaning: Meaning, pattern: str) -> None:
    """Texts are normalised here: without the non-joiner of బకెట్‌కు."""
    for text in texts_of(meaning):
        assert re.search(pattern, text), text


def test_every_verb_is_the_polite_imperative() -> None:
    for meaning in random_meanings.meanings(Random(32), 20):
        for sentence in TELUGU.write(meaning, Random(1)).rstrip(".").split(". "):
            assert re.search(r"(ండి|ంది,? దాన్ని .*ండి)$", sentence), sentence


def test_correct_spelling_with_the_non_joiner_is_not_suspicious() -> None:
    text = "చెట్టు దగ్గర ఎడమవైపుకు తిరిగి, చుక్కల ఎర్ర మగ్‌ను, తెల్ల కప్పును తీసుకోండి."
    assert check(text, "te", "navigation") == ()
    failures = check(text.replace("కప్పు", "క\u200dప్పు"), "te", "navigation")
    assert [failure.check for failure in failures] == ["normalisation"]


@pytest.mark.parametrize(
    ("text", "meaning"),
    [
        (
            "నేరుగా వెళ్ళి చెట్టు తరువాత కుడి వైపుకి తిరగండి. ఎర్ర చుక్కల మగ్ తీసుకోండి.",
            Navigation((Walk("ahead"), Rotate("right", "after", TREE)), MUG),
        ),
        (
            "బెంచీ వరకు వెళ్లు, అక్కడ ఎడమకి తిరుగు. చుక్కల ఎర్ర కప్పు తీసుకో.",
            Navigation((Walk("to", (BENCH,)), Rotate("left")), MUG),
        ),
    ],
)
def test_other_spellings_and_the_familiar_form_are_read(text: str, meaning: Navigation) -> None:
    read = TELUGU.read(text, "navigation")
    assert isinstance(read, Navigation)
    assert [type(step) for step in read.steps] == [type(step) for step in meaning.steps]
    assert (read.target.kind, read.target.colour, read.target.look) == ("mug", "red", "dotted")
