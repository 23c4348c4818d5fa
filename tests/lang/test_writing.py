"""Writing of English instructions: wording, spelling and variety."""

import re
from random import Random

import pytest

from arramon_lang import load
from arramon_lang.meaning import Assembly, Face, Navigation, Rotate, Thing, Walk, Where
from arramon_lang.quality import BLOCKED, check
from tests.lang import random_meanings

MUG = Thing("mug", "red", "striped", identity="3")
BENCH, BANNER = Thing("bench", identity="1"), Thing("banner", "orange", "star")
CROSSING = Thing("intersection", which="second")


def written(meaning: Navigation | Assembly, count: int = 60) -> list[str]:
    return [load("en").write(meaning, Random(seed)) for seed in range(count)]


def some(said: str, texts: list[str]) -> bool:
    return any(re.search(said, text, re.IGNORECASE) for text in texts)


def test_text_is_determined_by_meaning_and_seed() -> None:
    meaning = random_meanings.navigation(Random(5))
    assert load("en").write(meaning, Random(1)) == load("en").write(meaning, Random(1))
    assert len(set(written(meaning, 30))) == 30


@pytest.mark.parametrize(
    ("step", "said"),
    [
        (Rotate("slightly left"), r"turn slightly left|bear slightly left|slight left"),
        (Rotate("around"), r"turn around"),
        (Rotate("right", "at", CROSSING), r"right at the second (intersection|junction|crossing|crossroads)"),
        (Rotate("left", "before", BENCH), r"before the (park |street )?bench"),
        (Rotate("left", "after", BENCH), r"after the (park |street )?bench"),
        (Face(BENCH), r"(face|toward|towards) the (park |street )?bench"),
        (Walk("ahead", count=7), r"\b(7|seven) paces"),
        (Walk("to", (BENCH,)), r"(to|reach|at|far as|come to) the (park |street )?bench"),
        (Walk("past", (BENCH,), "left"), r"on (the|your) left"),
        (Walk("past", (Thing("intersection"),)), r"(cross|across|through|over) the "),
        (Walk("between", (BENCH, Thing("bench", identity="2"))), r"(the two|both) (park |street )?benches"),
        (Walk("between", (BENCH, Thing("tree"))), r"between the (park |street )?bench and the tree"),
        (Walk("along", (Thing("alley"),)), r"(down|through|along|into|follow) the alley"),
        (Walk("towards", (BANNER,)), r"towards? (the|an) .*(star|orange)"),
    ],
)
def test_steps_are_worded_as_expected(step: Rotate | Face | Walk, said: str) -> None:
    assert some(said, written(Navigation((step,), MUG)))


def test_repeated_mentions_become_short_references() -> None:
    texts = written(Navigation((Walk("to", (BENCH,)), Rotate("left", "at", BENCH)), MUG))
    assert some(r"left there", texts)
    assert not some(r"the same", texts)
    near = Thing("mug", "red", "striped", where=(Where("behind", (BENCH,)),))
    assert some(r"behind it", written(Navigation((Walk("to", (BENCH,)),), near)))
    twice = (Where("in_front_of", (MUG,)), Where("left_of", (MUG,)))
    assert some(r"in front of .*(its left|left of it)", written(Assembly((), Thing("ball"), twice)))


def test_landmark_relations_are_written_as_relative_clauses() -> None:
    behind = (Where("behind", (Thing("tree"),)),)
    near = Thing("mug", "red", "striped", where=(Where("near", (Thing("bench", where=behind),)),))
    texts = written(Navigation((), near))
    assert all(
        re.search(
            r"(bench|seat) (that|which) (is|sits) (just |right |)(behind|past|at the back of|in back of"
            r"|(to|at) the rear of|on the (far|other) side of|beyond|hidden behind|out of view behind"
            r"|around the back of) (the |)(\w+ |)tree",
            text,
        )
        for text in texts
    )


def test_articles_agree_with_the_next_word() -> None:
    text = "A orange hourglass, a hourglass, a ball and a arched wall."
    for pattern, replacement in load("en").grammar.spelling:
        text = re.sub(pattern, replacement, text)
    assert text == "An orange hourglass, an hourglass, a ball and an arched wall."


def test_written_texts_are_well_formed_and_pass_the_checks() -> None:
    random = Random(11)
    for meaning in random_meanings.meanings(random, 150):
        text = load("en").write(meaning, random)
        assert re.fullmatch(r"[A-Za-z0-9 ,;.'-]*[A-Za-z0-9.]", text), text
        assert not re.search(r"\s[,;.]|[,;.]{2}|  |[,;][^\s]|\.[^\s]", text), text
        assert text[0].islower() or not re.search(r"\. [a-z]", text), text  # Some voices type no capitals.
        assert not re.search(r"\b[Aa] (?=[aeiou]|hour)|\b[Aa]n (?![aeiou]|hour)", text), text
        assert not re.search(r"\b(for|about|roughly|some|the|a|just|shortly)[.,;]", text), text
        phase = "navigation" if isinstance(meaning, Navigation) else "assembly"
        assert [failure for failure in check(text, "en", phase) if failure.severity == BLOCKED] == [], text


def test_things_without_words_are_an_error() -> None:
    english = load("en")
    for thing, message in (
        (Thing("zeppelin"), "no noun for kind 'zeppelin'"),
        (Thing("mug", "mauve"), "no words for 'mauve'"),
        (Thing("banner", "red", "dotted"), "no words for the look 'dotted' of 'banner'"),
    ):
        with pytest.raises(ValueError, match=message):
            english.write(Navigation((Walk("to", (thing,)),), MUG), Random(0))
