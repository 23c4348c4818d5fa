"""Tables of `chunks.toml` that give relations and verbs their meaning: both languages' data, and errors."""

import tomllib
from typing import Any

import pytest

from arramon_lang.language import ROOT
from arramon_lang.reading.chunks.rules import load_rules


def data(code: str) -> dict[str, Any]:
    return tomllib.loads((ROOT / code / "chunks.toml").read_text(encoding="utf-8"))


@pytest.mark.parametrize(
    ("code", "negates_before", "stressing", "on"), [("en", True, ["right"], "on_top_of"), ("hi", False, [], "near")]
)
def test_languages_differ_in_their_data(code: str, negates_before: bool, stressing: list[str], on: str) -> None:
    rules = load_rules(data(code))
    assert rules.negates_before == negates_before
    assert sorted(rules.groups["stressing"]) == stressing
    assert rules.target_relations.get("on", "near") == on


@pytest.mark.parametrize(
    ("table", "entries", "message"),
    [
        ("negation", "behind", "negation: unknown 'behind'; expected one of after, before"),
        ("position", "between", "position: unknown 'between'; expected one of after, before"),
        ("words", {"stops": ["."]}, "words: unknown 'stops'"),
        ("verbs", {"fly": {"words": ["fly"]}}, "verbs: unknown 'fly'"),
        ("turn_positions", {"at": "near"}, "turn_positions: unknown 'near'"),
        ("walks", {"nearby": "to"}, "walks: unknown 'nearby'"),
        ("target_relations", {"at": "beside"}, "target_relations: unknown 'beside'"),
        ("verb_relations", {"fly": "past", "keep": "keep"}, "verb_relations: unknown 'fly'"),
        ("named_places", {"end": "bench"}, "named_places: unknown 'bench'"),
        ("groups", {"movers": ["turn"]}, "groups: unknown 'movers'"),
        ("groups", {"moving": ["fly"]}, "groups.moving: unknown 'fly'"),
        ("groups", {"stressing": ["up"]}, "groups.stressing: unknown 'up'"),
    ],
)
def test_unknown_entries_are_named(table: str, entries: object, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        load_rules(data("en") | {table: entries})
