"""Unigram tokenization agrees with SentencePiece."""

import pytest

from arramon_agents.pretrained.unigram import Unigram

SCORES = {
    "<unk>": 0.0,
    "\u2581": -2.0,
    "\u2581walk": -3.0,
    "ing": -2.5,
    "\u2581walking": -7.0,
    "i": -4.0,
    "n": -4.0,
}
UNIGRAM = Unigram(list(SCORES), list(SCORES.values()), 0, {ord("\t"): " ", ord("\u200d"): "", ord("\ufb01"): "in"})


@pytest.mark.parametrize(
    ("text", "pieces"),
    [
        ("walk", ["\u2581walk"]),
        ("walking", ["\u2581walk", "ing"]),  # -5.5 is more than -7.
        (" walk\t  walk", ["\u2581walk", "\u2581walk"]),
        ("\ufb01", ["\u2581", "i", "n"]),
        ("x\u200dy", ["\u2581", "<unk>", "<unk>"]),
        ("xing", ["\u2581", "<unk>", "ing"]),
        ("", ["\u2581"]),
    ],
)
def test_the_most_likely_pieces(text: str, pieces: list[str]) -> None:
    names = list(SCORES)
    assert [names[number] for number in UNIGRAM.encode(text)] == pieces
