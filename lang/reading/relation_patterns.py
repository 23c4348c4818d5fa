"""Patterns of relations: those of a language's phrases, and the phrases of its `relations.toml`."""

from collections.abc import Mapping
from typing import Any

from arramon_lang.grammar import Grammar
from arramon_lang.patterns import Alternatives, Slot
from arramon_lang.patterns import Sequence as Body
from arramon_lang.reading.matching import Automaton, PatternLabel, SplitWords


def relation_automaton(grammar: Grammar, relations: Mapping[str, Any], split: SplitWords) -> Automaton:
    """Return an automaton of all wordings of relations with their landmarks.

    Args:
        grammar: the language's grammar.
        relations: content of its `relations.toml`.
        split: splits a text into comparison keys.
    """
    automaton, also = Automaton(split, grammar.articles), grammar.also_read
    for key, patterns in grammar.where.items():
        automaton.add(key, patterns)
    known = {key.partition(" ")[0] for key in grammar.where}
    for key in also:
        if key.partition(" ")[0] in known:
            automaton.add(key, also[key], only_read=True)
    for relation, phrases in relations["phrases"].items():
        for phrase in set(phrases) - set(relations.get("by_themselves", [])):
            automaton.add_body(PatternLabel(relation, only_read=True), _phrase_body(relation, phrase, relations))
    return automaton


def _phrase_body(relation: str, phrase: str, relations: Mapping[str, Any]) -> Body:
    """Return the pattern of a phrase of `relations.toml`, with its landmark after or before it."""
    landmark: Body = (Alternatives(((Slot("thing"),), (Slot("joined"),))),)
    if relation == "between":
        two: Body = (Slot("thing"), f" {relations['conjunctions'][0]} ", Slot("other"))
        landmark = (Alternatives((two, (Slot("pair"),), (Slot("joined"),))),)
    return (f"{phrase} ", *landmark) if relations["position"] == "before" else (*landmark, f" {phrase}")
