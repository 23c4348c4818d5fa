"""Sounds of Devanagari words and of words typed in Latin letters."""

import pytest

import arramon_lang as lang
from arramon_lang.files import read_file
from arramon_lang.language import ROOT
from arramon_lang.reading.scripts.sounds import UNLIKE, Sounds, distance

SOUNDS = Sounds(read_file(ROOT / "hi", "latin"))


@pytest.mark.parametrize(
    ("word", "sounds"),
    [
        ("मुड़ो", ("muro", "mudo")),
        ("मुड़कर", ("murkar", "mudkar")),
        ("सड़क", ("sarak", "sadak")),
        ("निकलके", ("nikalke",)),
        ("में", ("men", "me")),
        ("चौराहा", ("cauraha",)),
        ("सफ़ेद", ("safed",)),
        ("व्हाइट", ("vhait",)),
    ],
)
def test_sounds_of_own_words(word: str, sounds: tuple[str, ...]) -> None:
    assert SOUNDS.own(lang.load("hi").normalise(word)) == sounds


@pytest.mark.parametrize(
    ("typed", "own"),
    [
        ("muro", "मुड़ो"), ("mudo", "मुड़ो"), ("phir", "फिर"), ("fir", "फिर"), ("seedhe", "सीधे"), ("sidhe", "सीधे"),
        ("wala", "वाला"), ("vaala", "वाला"), ("safed", "सफ़ेद"), ("nazdeek", "नज़दीक"), ("najdik", "नज़दीक"),
        ("peeche", "पीछे"), ("pichhe", "पीछे"),
    ],
)  # fmt: skip
def test_spellings_of_one_word_sound_alike(typed: str, own: str) -> None:
    assert min(distance(SOUNDS.typed(typed), each) for each in SOUNDS.own(lang.load("hi").normalise(own))) == 0.0


@pytest.mark.parametrize(
    ("typed", "nearer", "farther"),
    [("dayein", "दाएँ", "दें"), ("tk", "तक", "ठीक"), ("rkho", "रखो", "रुको"), ("chorahe", "चौराहे", "चौक")],
)
def test_left_out_and_confused_vowels_are_near(typed: str, nearer: str, farther: str) -> None:
    near, far = (
        min(distance(SOUNDS.typed(typed), each) for each in SOUNDS.own(lang.load("hi").normalise(word)))
        for word in (nearer, farther)
    )
    assert near < far


def test_short_words_with_other_consonants_are_unlike() -> None:
    assert distance("bal", "gal") == UNLIKE
    assert distance("", "a") < UNLIKE
