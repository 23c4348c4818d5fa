"""Correction of typing errors within the vocabulary, and terse notes."""

import pytest

import arramon_lang as lang
from arramon_lang.meaning import Assembly, Navigation, Rotate, Step, Walk
from arramon_lang.reading.typing_errors import TypingCorrector

DATA = {
    "keyboard": ["qwertyuiop", "asdfghjkl", "zxcvbnm"],
    "common": ["turn", "right", "the", "green", "red", "past", "and", "mug", "toward", "towards"],
    "known": ["for", "then"],
    "short": {"bldg": "building", "tl": "traffic light"},
    "rewriting": [],
}

CORRECTOR = TypingCorrector(["building", "bookcase", "form", *DATA["common"]], ["green", "red", "mug"], DATA)


@pytest.mark.parametrize(
    ("typed", "meant"),
    [
        ("trun right", "turn right"),
        ("trn rigth", "turn right"),
        ("teh gren mug", "the green mug"),
        ("the rde mug", "the red mug"),
        ("te mug", "the mug"),
        ("the red mgu", "the red mug"),
        ("towardw the", "towards the"),
        ("andpast the", "and past the"),
        ("turnrightand", "turn right and"),
        ("tur nright", "turn right"),
        ("bldg tl", "building traffic light"),
    ],
)
def test_errors_are_corrected(typed: str, meant: str) -> None:
    assert CORRECTOR.correct(typed.split()) == tuple(meant.split())


@pytest.mark.parametrize("typed", ["for the", "form the", "then red", "xq", "qqqqq", "12th", "tvrns"])
def test_known_words_and_unlikely_ones_stay(typed: str) -> None:
    assert CORRECTOR.correct(typed.split()) == tuple(typed.split())


def test_no_word_of_the_vocabulary_is_changed() -> None:
    english = lang.load("en").parser
    for word in sorted(word for word in english.vocabulary if word.isalpha()):
        assert english.expand(word) == (word,)


def directions(text: str) -> list[str]:
    meaning = lang.load("en").read(text, "navigation")
    assert isinstance(meaning, Navigation)
    return [step.direction for step in meaning.steps if isinstance(step, Rotate)]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("trun right and tak the red ball", ["right"]),
        ("tunr left at teh bench then trn rihgt and pick up the red ball", ["left", "right"]),
        ("Walk ahead, and right after the yellow awning make a left. Grab the red ball.", ["left"]),
        ("Go past the bench, and right before the bank take a left. Grab the red ball.", ["left"]),
        ("Go past the bench and right after the bank. Grab the red ball.", ["right"]),
        ("go into the second street on your right and pick up the red ball", ["right"]),
        ("Walk into the alley on your left. Grab the red ball.", ["left"]),
        ("straight, 2nd right, past red kiosk, grab red ball", ["right"]),
        ("R @ corner, L at bench. red ball", ["right", "left"]),
        ("wal past the bench and make a let, grab the red ball", ["left"]),
        ("go to the phone both till u see it then left, red ball", ["left"]),
    ],
)
def test_turns_of_hurried_texts(text: str, expected: list[str]) -> None:
    assert directions(text) == expected


@pytest.mark.parametrize(
    ("text", "turns", "relations"),
    [
        ("Left. White mug directly left of the red book.", ("left",), ["left_of"]),
        ("right, put the mug behind the red book", ("right",), ["behind"]),
        ("Left of the red book.", (), ["left_of"]),
        ("left, next to the red book", (), ["left_of", "near"]),
    ],
)
def test_a_side_that_is_a_sentence_is_a_turn(text: str, turns: tuple[str, ...], relations: list[str]) -> None:
    meaning = lang.load("en").read(text, "assembly")
    assert isinstance(meaning, Assembly)
    assert (meaning.turns, [where.relation for where in meaning.where]) == (turns, relations)


def test_a_terse_note() -> None:
    text = "twds yellow bldg, left. 3rd zebra xing, bin on left -> striped green bowl front of banner with star"
    meaning = lang.load("en").read(text, "navigation")
    assert isinstance(meaning, Navigation)
    towards, turn, crossing, bin_ = meaning.steps
    assert [described(step) for step in (towards, crossing, bin_)] == [
        ("towards", "building", "", ""), ("past", "zebra_crossing", "third", ""), ("past", "bin", "", "left"),
    ]  # fmt: skip
    assert turn == Rotate("left")
    assert (meaning.target.kind, meaning.target.colour, meaning.target.look) == ("bowl", "green", "striped")
    (where,) = meaning.target.where
    assert (where.relation, where.things[0].kind, where.things[0].look) == ("in_front_of", "banner", "star")


def described(step: Step) -> tuple[str, str, str, str]:
    assert isinstance(step, Walk)
    return step.way, step.things[0].kind, step.things[0].which, step.side


def test_the_target_is_not_what_it_lies_beside() -> None:
    meaning = lang.load("en").read("left, right at red cone; striped red mug by dotted blue ball", "navigation")
    assert isinstance(meaning, Navigation)
    assert (meaning.target.kind, meaning.target.where[0].things[0].kind) == ("mug", "ball")
