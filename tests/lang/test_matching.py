"""Search for patterns and phrases in a text's words."""

from collections.abc import Sequence

import pytest

from arramon_lang.patterns import parse
from arramon_lang.reading.matching import Automaton, Match, Phrasebook, with_and_without


def automaton(**patterns: str) -> Automaton:
    made = Automaton(lambda text: tuple(text.split()))
    for key, text in patterns.items():
        made.add(key, [parse(text)])
    return made


def found(matches: Sequence[Match]) -> set[tuple[str, int, tuple[tuple[str, object], ...]]]:
    return {(match.label.key, match.end, match.bound) for match in matches}


def test_all_patterns_and_all_readings_of_a_slot_are_found() -> None:
    keys = ("turn", "left", "at", "it")
    search = automaton(turn="turn {side}", at="turn {side} at {thing}", go="go {side}")

    def read(slot: str, at: int) -> list[tuple[int, object]]:
        readings: dict[tuple[str, int], list[tuple[int, object]]] = {
            ("side", 1): [(2, "left"), (3, "left at")], ("thing", 3): [(4, "it")],
        }  # fmt: skip
        return readings.get((slot, at), [])

    assert found(list(search.find(keys, 0, read))) == {
        ("turn", 2, (("side", "left"),)),
        ("turn", 3, (("side", "left at"),)),
        ("at", 4, (("side", "left"), ("thing", "it"))),
    }


def test_texts_may_omit_optional_words() -> None:
    search = Automaton(lambda text: tuple(text.split()), frozenset({"the"}))
    search.add("side", [parse("to the left of the door")])
    for text in ("to the left of the door", "to left of door"):
        keys = tuple(text.split())
        assert found(list(search.find(keys, 0, lambda _, at: []))) == {("side", len(keys), ())}
    assert with_and_without(("end", "of", "the", "road"), frozenset({"the"}))[1:] == [("end", "of", "road")]
    assert with_and_without(("the",), frozenset({"the"})) == [("the",)]


def test_slots_that_are_closed_at_an_index_are_not_asked_for_there() -> None:
    keys, asked = ("turn", "left", "it"), list[tuple[str, int]]()

    def read(slot: str, at: int) -> list[tuple[int, object]]:
        asked.append((slot, at))
        return [(at + 1, keys[at])]

    search = automaton(turn="turn {side} {thing}", face="turn {thing}")
    excluded = [frozenset[str](), frozenset({"thing"}), frozenset[str](), frozenset({"side", "thing"})]
    matches = list(search.find(keys, 0, read, excluded))
    assert found(matches) == {("turn", 3, (("side", "left"), ("thing", "it")))}
    assert asked == [("side", 1), ("thing", 2)]


@pytest.mark.parametrize(
    ("start", "expected"),
    [
        (0, [(2, "both"), (1, "one"), (0, "none")]),
        (1, [(1, "none")]),
        (2, [(3, "one"), (2, "none")]),
        (3, [(3, "none")]),
    ],
)
def test_longest_phrases_come_first_and_empty_ones_match_everywhere(start: int, expected: list[object]) -> None:
    book = Phrasebook()
    for text, meaning in (("red", "one"), ("red barrel", "both"), ("", "none")):
        book.add(tuple(text.split()), meaning)
    assert list(book.at(("red", "barrel", "red"), start)) == expected


def test_a_phrasebook_knows_by_the_word_where_nothing_begins() -> None:
    book = Phrasebook()
    book.add(("red", "barrel"), None)
    assert [book.may_begin(key) for key in ("red", "barrel", None)] == [True, False, False]
    book.add((), None)
    assert [book.may_begin(key) for key in ("red", "barrel", None)] == [True, True, True]
