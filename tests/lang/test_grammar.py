"""Grammars: word forms, word classes, and errors in the data."""

import tomllib
from typing import Any

import pytest

from arramon_lang.grammar import Grammar, Lexeme
from arramon_lang.language import ROOT

NAMES = ("grammar", "things", "phrases")


@pytest.fixture
def data() -> dict[str, Any]:
    return {name: tomllib.loads((ROOT / "en" / f"{name}.toml").read_text(encoding="utf-8")) for name in NAMES}


def loaded(data: dict[str, Any]) -> Grammar:
    return Grammar(*(data[name] for name in NAMES))


@pytest.mark.parametrize(
    ("features", "form"),
    [
        ({"case": "direct", "gender": "masculine"}, "हरा"),
        ({"case": "oblique", "gender": "masculine"}, "हरे"),
        ({"case": "oblique", "gender": "feminine"}, "हरी"),
        ({"gender": "neuter"}, None),
    ],
)
def test_word_form_is_the_most_specific_match(features: dict[str, str], form: str | None) -> None:
    word = Lexeme(
        (
            (frozenset({"masculine"}), "हरा"),
            (frozenset({"masculine", "oblique"}), "हरे"),
            (frozenset({"feminine"}), "हरी"),
        )
    )
    assert word.form(features) == form


def test_word_classes_append_endings_to_stems(data: dict[str, Any]) -> None:
    data["grammar"]["classes"] = {"regular": {"main": "", "ing": "ing"}}
    data["grammar"]["words"]["turn"] = {"class": "regular", "stem": "veer", "ing": "veering off"}
    (word,) = loaded(data).words["turn"]
    assert (word.form({"form": "main"}), word.form({"form": "ing"})) == ("veer", "veering off")


def test_words_have_weights(data: dict[str, Any]) -> None:
    data["grammar"]["words"]["turn"] = ["3* turn", {"weight": 0.5, "main": "veer", "ing": "veering"}, "pivot"]
    assert [word.weight for word in loaded(data).words["turn"]] == [3.0, 0.5, 1.0]


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        (
            ("phrases", "steps", "face"),
            ["{look} at {thing} {slowly}"],
            "steps.face: unknown word, table or slot 'slowly'",
        ),
        (("phrases", "steps", "face"), ["{face} {thing:dative}"], "steps.face: .*'dative' is not a value of a feature"),
        (("phrases", "steps", "face"), ["{face {thing}"], "unbalanced brackets"),
        (("things", "colours", "red"), ["{rouge}"], "colours.red: unknown word, table or slot 'rouge'"),
        (("grammar", "words", "turn"), {"gerund": "turning"}, "words.turn: 'gerund' is not a value of a feature"),
        (("grammar", "words", "turn"), {}, "words.turn: .* has no form"),
        (("phrases", "joins"), {"sentence": ["{a}"]}, "joins: assembly, first, later, .* missing"),
        (("phrases", "target", "purpose"), None, "target: purpose missing, which joins have"),
        (("things",), {}, "things.toml: 'nouns' is missing; it may be empty"),
        (("things", "colours", "red"), ["~red"], "things.toml: colours.red: '~red': only looks can follow the noun"),
        (("things", "whiches", "next"), ["~next"], "things.toml: whiches.next: '~next': only looks can follow"),
        (
            ("things", "nouns", "bench"),
            {"class": "regualr", "stem": "bench"},
            "things.toml: nouns.bench: no class 'regualr'; .classes. of grammar.toml has ",
        ),
        (("grammar", "text", "per_episode"), {"numeral": {"roman": 1}}, "per_episode: numeral is not an axis .* roman"),
    ],
)
def test_invalid_grammars_are_refused_with_the_reason(
    data: dict[str, Any], path: tuple[str, ...], value: Any, message: str
) -> None:
    table = data
    for key in path[:-1]:
        table = table[key]
    table[path[-1]] = value
    if value is None:
        del table[path[-1]]
    with pytest.raises(ValueError, match=message):
        loaded(data)
