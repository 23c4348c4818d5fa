"""Reader of instructions: matches the language's patterns against a text and skips what it does not understand."""

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from lang.discourse import Discourse, Item, things_in
from lang.grammar import Grammar
from lang.lexicon import FUZZY_LENGTH, keys_of, within_one_edit
from lang.matching import OPTIONAL, Automaton, Match, PatternLabel, Phrasebook
from lang.meaning import Meaning
from lang.noun_phrases import NounPhrase, NounPhraseReader, RelationPhrase
from lang.outline import Said, said_of
from lang.patterns import Choice, Pattern, Slot
from lang.patterns import Sequence as Body
from lang.tokens import Tokenizer

DEPTH = 2
"""Maximum nesting of landmarks described by landmarks."""

PHASES = ("navigation", "assembly")

_ITEM, _WHERE, _MENTION, _FILLER, _UNKNOWN = 0.2, 0.28, 0.8, 0.06, 1.0
"""Costs of reading a clause, a relation alone or a thing alone, of skipping a joining word, and any other word."""

_ALSO, _AMID, _UNUSUAL = 0.05, 0.3, 0.1
"""Extra costs of a clause that is only read, of a main clause that begins after other words, and of one about a thing
of another kind than its pattern is for."""

_Listed = Mapping[str, tuple[Pattern, ...]]


class CannotRead(ValueError):
    """Nothing in the text is understood; the message says what was expected."""


class Reader:
    """Reads one language's instructions.

    Args:
        grammar: of the language.
        lexicon: the content of its `lexicon.toml`.
        relations: the content of its `relations.toml`, whose phrases are recognised too.
        tokenizer: of the language.
    """

    def __init__(
        self, grammar: Grammar, lexicon: Mapping[str, Any], relations: Mapping[str, Any], tokenizer: Tokenizer
    ) -> None:
        self._grammar = grammar
        self._tokenizer = tokenizer
        self.noun_phrase_reader = NounPhraseReader(grammar, lexicon, self.split)
        self.books = self._books()
        also = grammar.also_read
        targets = {f"target {key}": patterns for key, patterns in grammar.target.items()}
        self.clauses = {
            "navigation": self._automaton(
                {**grammar.steps, **targets}, {key: also[key] for key in also if key in (*grammar.steps, "target")}
            ),
            "assembly": self._automaton(grammar.assembly, {key: also[key] for key in also if key in grammar.assembly}),
        }
        self.attached = self._automaton({"attached": grammar.attached, "nested": grammar.nested}, {})
        self.nested = self._automaton({"nested": grammar.nested}, {})
        self.relations = self._automaton(grammar.where, {key: also[key] for key in also if key in grammar.where})
        for relation, phrases in relations["phrases"].items():
            for phrase in phrases:
                self.relations.add_body(PatternLabel(relation, also=True), _phrase_body(relation, phrase, relations))
        self.joins = {
            True: self._joins(("where", "where of more", "where after clause")),
            False: self._joins(("nested where",)),
        }
        self.conjunctions = frozenset(relations["conjunctions"])
        self.exact_slots = frozenset(slot for slot, table in grammar.tables.items() if table.attribute == "exactly")
        self.fillers = self._fillers()
        self._vocabulary = frozenset(self._all_words())
        self._long = [word for word in self._vocabulary if len(word) >= FUZZY_LENGTH]
        self._never_fuzzy = frozenset(word.casefold() for word in lexicon["not_misspelt"])
        self._corrected: dict[str, str] = {}

    def split(self, text: str) -> tuple[str, ...]:
        """Return the comparison keys of a text."""
        return keys_of(self._tokenizer.split(text))

    def read(self, text: str, phase: str) -> Meaning:
        """Return the meaning of a text, as far as it is understood.

        Args:
            text: the instruction.
            phase: "navigation" or "assembly".

        Raises:
            ValueError: if the phase is another.
            CannotRead: if no part of it is understood.
        """
        if phase not in PHASES:
            raise ValueError(f"phase {phase!r}; expected {' or '.join(PHASES)}")
        items = [item for _, item in _Text(self, self._keys(text), phase).items()]
        if not items:
            expected = "what to pick up" if phase == "navigation" else "where to place what"
            raise CannotRead(f"nothing understood in {text[:80]!r}; expected steps or {expected}")
        discourse = Discourse(self._grammar)
        return discourse.navigation(items) if phase == "navigation" else discourse.assembly(items)

    def outline(self, text: str) -> tuple[Said, ...]:
        """Return the turns of a navigation instruction and the things that it mentions, in order; `outline` says how.

        Nothing is raised for a text of which nothing is understood: its outline is empty.
        """
        keys = self._keys(text)
        discourse = Discourse(self._grammar)
        said: list[Said] = []
        words, at = _Text(self, keys, "navigation"), 0
        for start, item in words.items():
            parts = [each for part in discourse.part(item) for each in said_of(part)]
            known = {each.thing.kind for each in parts if each.thing is not None}
            passing = [*words.names(at, start, set()), *words.names(start, item.end, known)]
            said += [*(Said(thing=discourse.mention(named), manner="seen") for named in passing), *parts]
            at = item.end
        rest = words.names(at, len(keys), set())
        return (*said, *(Said(thing=discourse.mention(named), manner="seen") for named in rest))

    def _keys(self, text: str) -> tuple[str, ...]:
        """Return a text's words for comparison, with typing errors corrected."""
        for pattern, replacement in self._grammar.reading:
            text = re.sub(pattern, replacement, text)
        return tuple(map(self._correct, self.split(self._tokenizer.normalise(text))))

    def _correct(self, key: str) -> str:
        """Return the word, corrected if exactly one known word is within one typing error."""
        if len(key) < FUZZY_LENGTH or key in self._vocabulary or key in self._never_fuzzy:
            return key
        if key not in self._corrected:
            near = [word for word in self._long if within_one_edit(key, word)]
            if len(near) > 1:  # The first letter is seldom wrong.
                near = [word for word in near if word[0] == key[0]]
            self._corrected[key] = near[0] if len(near) == 1 else key
        return self._corrected[key]

    def _books(self) -> dict[str, Phrasebook]:
        """Return, for each word and table slot, its possible forms."""
        books = {name: Phrasebook() for name in (*self._grammar.words, *self._grammar.tables)}
        for name, forms in self._grammar.word_forms().items():
            for form in forms:
                books[name].add(self.split(form), None)
        for slot, table in self._grammar.tables.items():
            for value, patterns in table.values.items():
                for text in sorted({text for pattern in patterns for text in self._grammar.spellings(pattern)}):
                    books[slot].add(self.split(text), value)
        return books

    def _automaton(self, listed: _Listed, also: _Listed) -> Automaton:
        automaton = Automaton(self.split)
        for key, patterns in listed.items():
            automaton.add(key, patterns)
        for key, patterns in also.items():
            automaton.add(key, patterns, also=True)
        return automaton

    def _joins(self, names: Iterable[str]) -> Automaton:
        automaton = Automaton(self.split)
        for name in names:
            for pattern in self._grammar.joins[name]:
                automaton.add_body(
                    PatternLabel(name), tuple(part for part in pattern.body if not isinstance(part, Slot))
                )
        return automaton

    def _fillers(self) -> frozenset[str]:
        """Return words that join clauses without a meaning of their own, and punctuation."""
        joins = Automaton(self.split)
        for patterns in self._grammar.joins.values():
            joins.add("", patterns)
        return frozenset(joins.vocabulary) | OPTIONAL

    def _all_words(self) -> Iterable[str]:
        yield from self.fillers
        yield from self.noun_phrase_reader.vocabulary
        for book in self.books.values():
            yield from book.vocabulary
        for automaton in (*self.clauses.values(), self.attached, self.nested, self.relations):
            yield from automaton.vocabulary


def _phrase_body(relation: str, phrase: str, relations: Mapping[str, Any]) -> Body:
    """Return the pattern of a phrase of `relations.toml`, with its landmark after or before it."""
    landmark: Body = (Choice(((Slot("thing"),), (Slot("joined"),))),)
    if relation == "between":
        two: Body = (Slot("thing"), f" {relations['conjunctions'][0]} ", Slot("other"))
        landmark = (Choice((two, (Slot("pair"),), (Slot("joined"),))),)
    return (f"{phrase} ", *landmark) if relations["position"] == "before" else (*landmark, f" {phrase}")


@dataclass(slots=True)
class _Text:
    """One text being read, with a memo of what was found at each index."""

    reader: Reader
    keys: tuple[str, ...]
    phase: str
    _memo: dict[tuple[str, int, int, bool], list[tuple[int, object]]] = field(default_factory=dict)

    def items(self) -> list[tuple[int, Item]]:
        """Return the understood parts in order, each with its start, from the cheapest division of the text."""
        size = len(self.keys)
        best: list[tuple[float, Item | None]] = [(0.0, None)] * (size + 1)
        for start in range(size - 1, -1, -1):
            skip = _FILLER if self.keys[start] in self.reader.fillers else _UNKNOWN
            best[start] = (best[start + 1][0] + skip, None)
            for item in self._items_at(start):
                cost = item.cost + best[item.end][0]
                if item.end > start and cost < best[start][0]:
                    best[start] = (cost, item)
        items, at = [], 0
        while at < size:
            chosen = best[at][1]
            if chosen is not None:
                items.append((at, chosen))
            at = chosen.end if chosen is not None else at + 1
        return items

    def _items_at(self, start: int) -> Iterable[Item]:
        automaton = self.reader.clauses[self.phase]
        amid = start > 0 and self.keys[start - 1] not in self.reader.fillers
        for match in automaton.find(self.keys, start, lambda slot, at: self._slot(slot, at, DEPTH, top=True)):
            unusual = not self._is_usual(match)
            cost = _ITEM + _ALSO * match.label.also + _AMID * (amid and match.label.main_only) + _UNUSUAL * unusual
            yield Item(match.end, match.label.key, match.bound, cost)
        for end, named in self._slot("target", start, DEPTH, top=True):
            yield Item(end, "mention", (("target", named),), _MENTION)
        for end, wheres in self._slot("where", start, DEPTH, top=True):
            yield Item(end, "where", (("where", wheres),), _WHERE)

    def _is_usual(self, match: Match) -> bool:
        kind = match.label.key.rpartition(" ")[2]
        return kind not in self.reader.noun_phrase_reader.kinds or all(
            named.kind == kind for slot, named in match.bound if slot == "thing" and isinstance(named, NounPhrase)
        )

    def _slot(self, slot: str, at: int, depth: int, *, top: bool) -> list[tuple[int, object]]:
        key = (slot, at, depth, top)
        if key not in self._memo:
            self._memo[key] = self._read_slot(slot, at, depth, top=top)
        return self._memo[key]

    def _read_slot(self, slot: str, at: int, depth: int, *, top: bool) -> list[tuple[int, object]]:
        reader = self.reader
        if slot in reader.books:
            return list(reader.books[slot].at(self.keys, at))
        if slot == "where":
            return [(end, wheres) for end, wheres in self._wheres(at, depth, top=top)]
        if slot == "joined":
            return list(reader.noun_phrase_reader.read_joined(self.keys, at, reader.conjunctions))
        if slot in ("thing", "other"):
            return [*self._noun_phrases_at(at), *self._located_things(reader.nested, at, depth, top=False)]
        if slot == "target":
            found = [*self._noun_phrases_at(at), *self._located_things(reader.attached, at, depth, top=True)]
            return [
                (end, named)
                for end, named in found
                if isinstance(named, NounPhrase) and reader.noun_phrase_reader.is_collectible(named)
            ]
        number = {"pair": "two", "several": "several"}.get(slot)
        return [
            (end, named)
            for end, named in self._noun_phrases_at(at)
            if number is None or (isinstance(named, NounPhrase) and named.number == number)
        ]

    def names(self, start: int, end: int, known: set[str]) -> Iterator[NounPhrase]:
        """Yield things named between two words, long names first: no collectibles, and no kinds that are known."""
        at = start
        while at < end:
            found = [
                (to, named) for to, named in self._noun_phrases_at(at) if to <= end and isinstance(named, NounPhrase)
            ]
            at, named = max(found, key=lambda each: each[0], default=(at + 1, None))
            if named is None or named.back or named.kind in known:
                continue
            if not self.reader.noun_phrase_reader.is_collectible(named):
                yield named

    def _noun_phrases_at(self, at: int) -> list[tuple[int, object]]:
        key = ("", at, 0, False)
        if key not in self._memo:
            self._memo[key] = list(self.reader.noun_phrase_reader.read(self.keys, at))
        return self._memo[key]

    def _located_things(self, automaton: Automaton, at: int, depth: int, *, top: bool) -> list[tuple[int, object]]:
        """Return things with relations."""
        if depth == 0:
            return []

        def read(slot: str, place: int) -> list[tuple[int, object]]:
            return self._noun_phrases_at(place) if slot == "thing" else self._slot(slot, place, depth - 1, top=top)

        found: list[tuple[int, object]] = []
        for match in automaton.find(self.keys, at, read):
            bound = dict(match.bound)
            thing, where = bound["thing"], bound["where"]
            assert isinstance(thing, NounPhrase)
            assert isinstance(where, tuple)
            found.append((match.end, replace(thing, where=where)))
        return found

    def _wheres(self, at: int, depth: int, *, top: bool) -> list[tuple[int, tuple[RelationPhrase, ...]]]:
        found: list[tuple[int, tuple[RelationPhrase, ...]]] = self._relations_at(at, depth)
        longer = list(found)
        for _ in range(2):
            longer = [
                (end, (*wheres, *placed))
                for before, wheres in longer
                for join in self.reader.joins[top].find(self.keys, before, lambda *_: ())
                for end, placed in self._relations_at(join.end, depth)
            ]
            longer = list(dict.fromkeys(longer))
            found += longer
        return found

    def _relations_at(self, at: int, depth: int) -> list[tuple[int, tuple[RelationPhrase, ...]]]:
        """Return relations: a single one, or one to each of two things that share a noun."""
        found: list[tuple[int, tuple[RelationPhrase, ...]]] = []
        matches = list(
            self.reader.relations.find(self.keys, at, lambda slot, place: self._slot(slot, place, depth, top=False))
        )
        written = {match.end for match in matches if not match.label.also}
        for match in matches:
            if match.label.also and match.end in written:
                continue
            bound = dict(match.bound)
            relation, _, kind = match.label.key.partition(" ")
            exactly = not self.reader.exact_slots.isdisjoint(bound)
            things = things_in(bound, kind, is_between=relation == "between")
            each = [(thing,) for thing in things] if "joined" in bound and relation != "between" else [things]
            found.append((match.end, tuple(RelationPhrase(relation, about, exactly) for about in each)))
        return list(dict.fromkeys(found))
