"""Data of the lexicons, and recognition of words with typing errors."""

import tomllib
from itertools import product
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from arramon_client.world import COLLECTIBLE_COLOURS, COLLECTIBLE_PATTERNS, COLLECTIBLES
from arramon_lang.language import ROOT, available, load
from arramon_lang.lexicon import Lexicon, within_one_edit
from arramon_lang.tokens import ScriptTokenizer

EMPTY: dict[str, Any] = {
    "kinds": {}, "patterned_kinds": {}, "patterns": {}, "colours": {},
    "modifiers": [], "stand_ins": [], "others": [], "having": [], "not_misspelt": [],
}  # fmt: skip


@pytest.mark.parametrize("code", available())
def test_every_language_has_words_for_the_whole_catalogue(code: str) -> None:
    data = tomllib.loads((ROOT / code / "lexicon.toml").read_text(encoding="utf-8"))
    assert set(data) == set(EMPTY)
    assert tuple(data["kinds"]) == COLLECTIBLES
    assert tuple(data["patterns"]) == COLLECTIBLE_PATTERNS
    assert tuple(data["colours"]) == COLLECTIBLE_COLOURS
    assert set(data["patterned_kinds"]) <= set(COLLECTIBLES)


@pytest.mark.parametrize("code", available())
def test_every_lexicon_phrase_is_recognised_with_its_meaning(code: str) -> None:
    data = tomllib.loads((ROOT / code / "lexicon.toml").read_text(encoding="utf-8"))
    language = load(code)
    for value, phrases in data["kinds"].items():
        for phrase in phrases:
            assert [mention.kind for mention in language.find_objects(phrase)] == [value], phrase
    ball = data["kinds"]["ball"][0]
    for role, name in (("patterns", "pattern"), ("colours", "colour")):
        for value, phrases in data[role].items():
            for phrase in phrases:
                (mention,) = language.find_objects(f"{phrase} {ball}")
                assert (getattr(mention, name), mention.kind) == (value, "ball"), phrase


@pytest.mark.parametrize(
    ("written", "word", "expected"),
    [
        ("striped", "striped", True),
        ("stiped", "striped", True),  # left out
        ("triped", "striped", True),
        ("stripe", "striped", True),
        ("strippped", "stripped", True),  # added
        ("dtriped", "striped", True),  # exchanged
        ("dooted", "dotted", True),
        ("horuglass", "hourglass", True),  # swapped with its neighbour
        ("strpied", "striped", True),
        ("tsriped", "striped", True),
        ("stripde", "striped", True),
        ("tsripde", "striped", False),
        ("strped", "stripes", False),
        ("abcde", "edcba", False),
        ("dotted", "potter", False),
        ("abcd", "abdce", False),
        ("book", "", False),
        ("", "a", True),
    ],
)
def test_within_one_edit_recognises_typing_errors(written: str, word: str, expected: bool) -> None:
    assert within_one_edit(written, word) is expected
    assert within_one_edit(word, written) is expected


@given(st.text("abc", max_size=5), st.text("abc", max_size=5))
def test_within_one_edit_equals_all_single_edits(a: str, b: str) -> None:
    edited = {a}
    for i in range(len(a) + 1):
        edited |= {a[:i] + letter + a[i:] for letter in "abc"}
        edited |= {a[:i] + letter + a[i + 1 :] for letter in ("a", "b", "c", "")}
        if i + 1 < len(a):
            edited.add(a[:i] + a[i + 1] + a[i] + a[i + 2 :])
    assert within_one_edit(a, b) is (b in edited)


def test_word_near_two_meanings_is_not_recognised() -> None:
    data = EMPTY | {"colours": {"red": ["crimson"]}, "kinds": {"mug": ["brimson"]}}
    lexicon = Lexicon(data, ScriptTokenizer("a-z"))
    assert lexicon.read(["frimson"], 0) is None
    found = lexicon.read(["crimsom"], 0)
    assert found is not None
    assert found.value == "red"


def test_a_phrase_with_two_meanings_is_an_error() -> None:
    for first, second in product(("kinds", "colours"), ("patterns", "patterned_kinds")):
        with pytest.raises(ValueError, match=r"(?i)'rose' is listed as"):
            Lexicon(EMPTY | {first: {"red": ["rose"]}, second: {"ball": ["Rose"]}}, ScriptTokenizer("a-zA-Z"))


def test_a_missing_table_is_an_error() -> None:
    with pytest.raises(ValueError, match="'colours' is missing"):
        Lexicon({key: value for key, value in EMPTY.items() if key != "colours"}, ScriptTokenizer("a-z"))
