"""Tokenisation and normalisation of texts in both scripts."""

import unicodedata

import pytest
from hypothesis import given
from hypothesis import strategies as st

from arramon_lang import load
from arramon_lang.tokens import strip_marks


@pytest.mark.parametrize(
    ("code", "text", "expected"),
    [
        ("en", "Turn left, don't stop.", ["Turn", "left", ",", "don't", "stop", "."]),
        ("en", "polka-dot TV (90 degrees)", ["polka", "-", "dot", "TV", "(", "90", "degrees", ")"]),
        ("en", "right.Place  it\n", ["right", ".", "Place", "it"]),
        ("en", "café e\u0301", ["café", "é"]),
        ("en", "", []),
        # Vowel signs, the virama and the nukta belong to their word; the danda is a token of its own.
        ("hi", "किताब उठाएँ।", ["किताब", "उठाएँ", "।"]),
        ("hi", "रेतघड़ी, ट्रैफ़िक कोन॥", ["रेतघड़ी", ",", "ट्रैफ़िक", "कोन", "॥"]),
        ("hi", "१२ कदम, 90 डिग्री", ["१२", "कदम", ",", "90", "डिग्री"]),
        ("hi", "साथ-साथ TV टीवी", ["साथ", "-", "साथ", "TV", "टीवी"]),
        ("hi", "दीवार\u200c के क\u094d\u200dष", ["दीवार", "के", "क\u094dष"]),
        ("hi", "टी.वी.", ["टी", ".", "वी", "."]),
        # A nukta written as one character and as two is one word.
        ("hi", "लक\u095cी लकड\u093cी", ["लकड\u093cी", "लकड\u093cी"]),
    ],
)
def test_texts_are_split_into_tokens(code: str, text: str, expected: list[str]) -> None:
    assert load(code).tokenize(text) == [unicodedata.normalize("NFC", token) for token in expected]


@pytest.mark.parametrize(
    ("code", "text", "expected"),
    [
        ("en", "  Turn\tleft.\n\nGo  on ", "Turn left. Go on"),
        ("en", "cafe\u0301", "caf\u00e9"),
        ("hi", "बड\u093cा  मग ", "बड\u093cा मग"),
        ("hi", "ब\u095cा", "ब" + "ड\u093c" + "ा"),  # NFC leaves the nukta decomposed
        ("hi", "क\u094d\u200dष\u200c मग", "क\u094dष मग"),
    ],
)
def test_texts_are_normalised(code: str, text: str, expected: str) -> None:
    assert load(code).normalise(text) == expected


@pytest.mark.parametrize("code", ["en", "hi"])
@given(st.text(st.characters(codec="utf-8") | st.sampled_from("कड\u093c\u095cाीं।१ \u200d\u200ctv."), max_size=20))
def test_normalisation_is_idempotent(code: str, text: str) -> None:
    language = load(code)
    once = language.normalise(text)
    assert language.normalise(once) == once


@pytest.mark.parametrize("code", ["en", "hi"])
@given(st.text(st.sampled_from("कडिताबी।१2 tv.,'-\n"), max_size=20))
def test_tokenisation_loses_only_white_space(code: str, text: str) -> None:
    assert "".join(load(code).tokenize(text)) == "".join(text.split())


@pytest.mark.parametrize(
    ("word", "expected"),
    [
        ("bench.", "bench"),
        ("“बेंच”।", "बेंच"),
        ("بینچ۔", "بینچ"),
        ("T-junction,", "T-junction"),
        ("—", ""),
        ("చెట్టు…", "చెట్టు"),
    ],
)
def test_marks_of_every_script_are_stripped_from_words(word: str, expected: str) -> None:
    assert strip_marks(word) == expected
