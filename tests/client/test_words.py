"""Words of a text in any script."""

import pytest

from arramon_client.words import words

SPLIT = [
    ("Turn left.", ["turn", "left", "."]),
    ("  Don't  stop,\ngo! ", ["don", "'", "t", "stop", ",", "go", "!"]),
    ("बाएँ मुड़ें और बेंच तक जाएँ।", ["बाएँ", "मुड़ें", "और", "बेंच", "तक", "जाएँ", "।"]),
    ("क्\u200dष 12", ["क्\u200dष", "12"]),
    ("", []),
]


@pytest.mark.parametrize(("text", "expected"), SPLIT)
def test_words(text: str, expected: list[str]) -> None:
    assert words(text) == expected
