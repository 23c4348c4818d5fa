"""Case marks in Hindi's patterns: nouns before postpositions, and participles."""

from itertools import pairwise

from arramon_lang import load
from arramon_lang.patterns import Alternatives, Sequence, Slot


def readings(body: Sequence) -> list[list[str | Slot]]:
    """Return all sequences of words and slots that a pattern allows."""
    found: list[list[str | Slot]] = [[]]
    for part in body:
        options = (
            [each for option in part.options for each in readings(option)] if isinstance(part, Alternatives) else []
        )
        more = options or [[part] if isinstance(part, Slot) else list(str(part).split())]
        found = [[*before, *after] for before in found for after in more]
    return found


def test_nouns_before_a_postposition_are_marked_oblique() -> None:
    """In all patterns, exactly the things before a postposition are marked oblique."""
    grammar = load("hi").grammar
    postpositions = {"का", "के", "की", "को", "से", "पर", "तक", "में", "और", "दोनों"}
    checked = 0
    for group in (grammar.steps, grammar.where, grammar.target, grammar.assembly, grammar.also_read):
        for pattern in (pattern for patterns in group.values() for pattern in patterns):
            for parts in readings(pattern.body):
                for slot, after in pairwise([*parts, ""]):
                    if isinstance(slot, Slot) and slot.name in ("thing", "other", "pair", "target"):
                        assert ("oblique" in slot.marks) == (after in postpositions), pattern.text
                        checked += 1
    assert checked > 1000


def test_a_participle_has_the_case_of_its_noun() -> None:
    """बेंच के पास रखे मग को, not रखा: of all patterns, a word that agrees has the marks of the thing that follows it."""
    grammar = load("hi").grammar
    checked = 0
    for group in (grammar.steps, grammar.where, grammar.target, grammar.assembly, grammar.also_read):
        for pattern in (pattern for patterns in group.values() for pattern in patterns):
            for parts in readings(pattern.body):
                for word, noun in pairwise(parts):
                    if (
                        isinstance(word, Slot)
                        and isinstance(noun, Slot)
                        and word.name in ("lying", "been", "vala", "of")
                    ):
                        assert word.marks == noun.marks, pattern.text
                        checked += 1
    assert checked
