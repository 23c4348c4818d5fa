"""What a language's relations and verbs mean: `chunks.toml` from [turn_positions] to [groups]."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from arramon_lang.meaning import PLACES, RELATIONS, TURN_POSITIONS, WAYS

_POSITIONS = ("before", "after")

_IMPLIED = ("left_of", "right_of", "")
"""Relations that need no words of their own: a side of something, and none."""

_WORDS = (
    *("comma", "and", "then", "stop", "or", "but", "not", "correction", "repeat"),
    *("it", "them", "all", "again", "there", "where", "which", "until", "one_side", "other_side"),
    *("back", "back_again", "round", "behind_you", "away", "straight", "ahead", "tile"),
)
"""Keys of [words]: kinds of words that the parsers distinguish; a language may lack some of them."""

_VERBS = (
    *("turn", "turn_round", "swing", "bear", "look", "back", "become"),
    *("walk", "return", "pass", "cross", "follow", "keep"),
    *("see", "come", "be", "end", "take", "place"),
)
"""Keys of [verbs]: classes of verbs that the parsers distinguish; a language may lack some of them."""

_GROUPS = {
    "relations": (
        "describing",
        "leading",
        "passing",
        "listing",
        "reached",
        "at_turn",
        "placing",
        "stepping",
        "stressed",
    ),
    "verbs": ("moving", "standing"),
    "sides": ("stressing",),
}
"""Keys of [groups], by the table whose keys they list."""


@dataclass(frozen=True, slots=True)
class ChunkRules:
    """Meanings of the keys of [relations] and [verbs]; the comments of `lang/en/chunks.toml` describe each table.

    Attributes:
        has_prepositions: whether relations precede the thing, as in English; otherwise they follow it, as in Hindi.
        negates_before: whether "not" may precede what is not meant; otherwise it follows.
        turn_positions: where a turn is made, one of `meaning.TURN_POSITIONS`, by relation.
        walks: one of `meaning.WAYS`, by relation.
        target_relations: relation of the target, one of `meaning.RELATIONS`, by relation.
        room_relations: the same for the object to place.
        opposites: relation of the target to a thing, by the thing's relation to the target.
        verb_relations: the relation that a verb expresses by itself ("pass the bench").
        named_places: the kind of place that a relation names itself ("to the end").
        groups: relations, verbs or sides by the name of their group.
    """

    has_prepositions: bool
    negates_before: bool
    turn_positions: Mapping[str, str]
    walks: Mapping[str, str]
    target_relations: Mapping[str, str]
    room_relations: Mapping[str, str]
    opposites: Mapping[str, str]
    verb_relations: Mapping[str, str]
    named_places: Mapping[str, str]
    groups: Mapping[str, frozenset[str]]

    def is_in(self, value: str, *groups: str) -> bool:
        """Return whether a relation, verb or side belongs to one of the groups."""
        return any(value in self.groups[group] for group in groups)


def load_rules(data: Mapping[str, Any]) -> ChunkRules:
    """Return the rules of a language.

    Args:
        data: the content of its `chunks.toml`.

    Raises:
        ValueError: if an entry has an unknown key or value; names the entry.
    """
    _check("position", [data["position"]], _POSITIONS)
    _check("negation", [data["negation"]], _POSITIONS)
    _check("words", data["words"], _WORDS)
    _check("verbs", data["verbs"], _VERBS)
    relations = {*data["relations"], *data.get("verb_relations", {}).values(), *_IMPLIED}
    listed = {"relations": relations, "verbs": {*data["verbs"]}, "sides": {*data["sides"]}}

    def table(name: str, keys: Iterable[str], values: Iterable[str]) -> Mapping[str, str]:
        entries: Mapping[str, str] = data.get(name, {})
        _check(name, entries, keys)
        _check(name, entries.values(), values)
        return entries

    groups: Mapping[str, Iterable[str]] = data.get("groups", {})
    _check("groups", groups, [name for names in _GROUPS.values() for name in names])
    for kind, names in _GROUPS.items():
        for name in names:
            _check(f"groups.{name}", groups.get(name, ()), listed[kind])
    return ChunkRules(
        data["position"] == "before",
        data["negation"] == "before",
        table("turn_positions", relations, TURN_POSITIONS),
        table("walks", relations, WAYS),
        table("target_relations", relations, RELATIONS),
        table("room_relations", relations, RELATIONS),
        table("opposites", relations, relations),
        table("verb_relations", data["verbs"], relations),
        table("named_places", relations, PLACES),
        {name: frozenset(groups.get(name, ())) for names in _GROUPS.values() for name in names},
    )


def _check(entry: str, found: Iterable[str], known: Iterable[str]) -> None:
    unknown = sorted(set(found) - set(known))
    if unknown:
        expected = ", ".join(sorted(filter(None, known)))
        raise ValueError(f"chunks: {entry}: unknown {', '.join(map(repr, unknown))}; expected one of {expected}")
