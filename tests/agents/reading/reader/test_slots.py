"""Conversion of meanings to rows of slots and back."""

from random import Random

import pytest

from arramon_agents.reading.reader.slots import SLOTS, TYPES, meaning_of, rows_of
from arramon_agents.reading.reader.spelling import MAX_NGRAMS, hash_ngrams, misspell
from arramon_agents.reading.reader.vocabulary import UNKNOWN, Vocabulary, split
from arramon_lang.meaning import Assembly, Face, Meaning, Navigation, Rotate, Thing, Walk, Where

BENCH, MUG = Thing("bench"), Thing("mug", "red", "dotted")

MEANINGS: list[tuple[str, Meaning]] = [
    ("navigation", Navigation((), MUG)),
    ("navigation", Navigation((Rotate("left"), Walk("ahead", count=4), Face(BENCH)), MUG)),
    (
        "navigation",
        Navigation(
            (
                Rotate("right", "before", Thing("banner", "black", "star", which="second")),
                Walk("between", (Thing("cone", "red"), Thing("barrel", "gold"))),
                Walk("past", (Thing("bench", number="two", where=(Where("near", (Thing("tree"),)),)),), "left"),
                Walk("to", (Thing("intersection"),)),
            ),
            Thing("", "", "dotted", where=(Where("behind", (MUG,), exactly=True), Where("between", (BENCH, MUG)))),
        ),
    ),
    ("assembly", Assembly((), Thing(""), (Where("on_top_of", (MUG,)),))),
    (
        "assembly",
        Assembly(("left", "around"), MUG, (Where("against", (Thing("wall", look="brick"),)), Where("near", (BENCH,)))),
    ),
]


@pytest.mark.parametrize(("phase", "meaning"), MEANINGS)
def test_a_meaning_is_got_back_from_its_rows(phase: str, meaning: Meaning) -> None:
    rows = rows_of(meaning)
    assert all(len(row) == len(SLOTS) for row in rows)
    assert meaning_of(rows, phase) == meaning


def test_what_no_slot_has_is_refused() -> None:
    with pytest.raises(ValueError, match="kind1 'dragon' is not one of"):
        rows_of(Navigation((Face(Thing("dragon")),), MUG))
    with pytest.raises(ValueError, match="rows"):
        rows_of(Navigation((Rotate("left"),) * 30, MUG))


def test_rows_that_make_no_step_are_left_out() -> None:
    nothing = [0] * len(SLOTS)
    names = list(SLOTS)
    walk = list(nothing)
    walk[0], walk[names.index("way")] = TYPES.index("walk"), SLOTS["way"].index("past")
    assert meaning_of([tuple(walk), tuple(nothing)], "navigation") == Navigation((), Thing(""))
    assert meaning_of([tuple(nothing)], "assembly") == Assembly((), Thing(""), ())


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("Turn left, then don't STOP-here.", ["turn", "left", ",", "then", "don't", "stop-here", "."]),
        ("बिंदीदार लाल टीवी को उठा लें।", ["बिंदीदार", "लाल", "टीवी", "को", "उठा", "लें", "।"]),
        ("", []),
    ],
)
def test_texts_are_split_into_words(text: str, words: list[str]) -> None:
    assert split(text) == words


def test_a_vocabulary_numbers_frequent_words() -> None:
    vocabulary = Vocabulary.of(["b a a", "a b c"], fewest=2)
    assert vocabulary.words == ("a", "b")
    assert [code[0] for code in vocabulary.encode("a c b")] == [UNKNOWN + 1, UNKNOWN, UNKNOWN + 2]
    assert vocabulary.encode("") == [(UNKNOWN, *[0] * MAX_NGRAMS)]
    assert len(vocabulary) == 4


def test_words_that_are_spelt_alike_share_ngrams() -> None:
    right, swapped, other = ({*hash_ngrams(word)} - {0} for word in ("kiosk", "kisok", "bench"))
    assert len(right) == 4 + 6 + 5, "its letters, with one k, and its n-grams of two and three"
    assert len(right & swapped) > 2 * len(right & other)
    assert len(hash_ngrams("intersection" * 9)) == MAX_NGRAMS


def test_a_misspelling_is_one_error_away() -> None:
    random = Random(3)
    typed = {misspell("turn", "x", random) for _ in range(200)}
    swapped, left_out = ["utrn", "trun", "tunr"], ["urn", "trn", "tun"]
    doubled, replaced = ["tturn", "tuurn", "turrn"], ["txrn", "tuxn", "turx"]
    assert typed == {*swapped, *left_out, *doubled, *replaced}
    assert misspell("in", "x", random) == "in"
