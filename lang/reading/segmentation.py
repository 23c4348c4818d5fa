"""Segmentation of a text into understood parts, at minimum cost."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from arramon_lang.files import BARE
from arramon_lang.reading.discourse import ParsedPart, bound_things
from arramon_lang.reading.matching import Automaton, Match
from arramon_lang.reading.parsed_phrases import NounPhrase, RelationPhrase

if TYPE_CHECKING:
    from arramon_lang.reading.parser import InstructionParser

DEPTH = 2
"""Maximum nesting depth of landmarks described by other landmarks."""

_CLAUSE, _WHERE, _WHERE_MORE, _MENTION, _FILLER, _UNKNOWN = 0.2, 0.28, 0.37, 0.8, 0.06, 1.0
"""Costs of a clause, a separate relation, each relation joined to it, and a separate thing; of skipping a joining word,
and any other word."""

_SLOT_BONUS = 0.01
"""Discount per filled slot of a clause that is only read, so that more specific clauses win."""

_WHERE_JOINED = 0.08
"""Extra cost of each additional relation within a clause that is only read."""

_WHERE_AT_TURN = 0.35
"""Extra cost of a separate relation where a turn may begin: "left to the planter" is not a place to its left."""

_ONLY_READ, _NOT_INITIAL, _OTHER_KIND, _NO_KIND = 0.05, 0.3, 0.1, 0.02
"""Extra costs of a clause that is only read, of a main clause in the middle of a sentence, of a thing whose kind
differs from the pattern's, and of a thing without a kind if another pattern states one."""


@dataclass(slots=True)
class TextSegmenter:
    """Segmentation of one text, with a memo of the matches at each index.

    Attributes:
        parser: the language's parser.
        keys: the text's words.
        phase: "navigation" or "assembly".
        written_only: whether patterns that are only read are excluded.
    """

    parser: "InstructionParser"
    keys: tuple[str, ...]
    phase: str
    written_only: bool = False
    _memo: dict[tuple[str, int, int, bool], list[tuple[int, object]]] = field(default_factory=dict)
    _related: dict[tuple[int, int, bool], list[tuple[int, tuple[RelationPhrase, ...]]]] = field(default_factory=dict)
    _excluded: list[frozenset[str]] = field(init=False)

    def __post_init__(self) -> None:
        self._excluded = [self.parser.excluded_slots(key) for key in (*self.keys, None)]

    def items(self) -> list[tuple[int, ParsedPart]]:
        """Return the (start, part) pairs of the cheapest segmentation, in order."""
        size = len(self.keys)
        best: list[tuple[float, ParsedPart | None]] = [(0.0, None)] * (size + 1)
        for start in range(size - 1, -1, -1):
            skip = _FILLER if self.keys[start] in self.parser.fillers else _UNKNOWN
            best[start] = (best[start + 1][0] + skip, None)
            for item in self._items_at(start):
                cost = item.cost + best[item.end][0]
                if item.end > start and cost < best[start][0]:
                    best[start] = (cost, item)
        items: list[tuple[int, ParsedPart]] = []
        at = 0
        while at < size:
            chosen = best[at][1]
            if chosen is not None:
                last = items[-1][1] if items else None
                if chosen.label == "where" and last is not None and last.label == "where" and last.end == at:
                    chosen = replace(chosen, begins_clause=last.begins_clause)
                if last is not None and self._is_joined(last.end, at):
                    chosen = replace(chosen, joined=True)
                items.append((at, chosen))
            at = chosen.end if chosen is not None else at + 1
        return items

    def is_covered_by(self, items: list[tuple[int, ParsedPart]]) -> bool:
        """Return whether clauses and joining words cover the whole text, including a target in navigation."""
        at, is_found = 0, self.phase == "assembly"
        for start, item in items:
            if item.label == "mention" or (item.label == "where" and not is_found) or self._skips_words(at, start):
                return False
            at, is_found = item.end, is_found or item.label.startswith("target")
        return is_found and not self._skips_words(at, len(self.keys))

    def _is_joined(self, start: int, end: int) -> bool:
        """Return whether there are only commas and "and" between two words, and at least one."""
        return start < end and all(key == "," or key in self.parser.conjunctions for key in self.keys[start:end])

    def _skips_words(self, start: int, end: int) -> bool:
        return any(key not in self.parser.fillers for key in self.keys[start:end])

    def _items_at(self, start: int) -> Iterable[ParsedPart]:
        automaton = self.parser.clauses[self.phase]
        amid = start > 0 and self.keys[start - 1] not in self.parser.fillers
        begins_clause = start == 0 or self.keys[start - 1] in self.parser.openers

        def read(slot: str, at: int) -> list[tuple[int, object]]:
            return self._slot(slot, at, DEPTH, top=True)

        for match in automaton.find(self.keys, start, read, self._excluded):
            if (match.label.key.endswith(BARE) and not begins_clause) or (match.label.only_read and self.written_only):
                continue
            unusual = 0.0 if self._is_usual(match) else _NO_KIND if self._is_nameless(match) else _OTHER_KIND
            cost = (
                _CLAUSE + _ONLY_READ * match.label.only_read + _NOT_INITIAL * (amid and match.label.main_only) + unusual
            )
            cost += match.label.only_read * (_WHERE_JOINED * _more_wheres(match) - _SLOT_BONUS * len(match.bound))
            yield ParsedPart(match.end, match.label.key, match.bound, cost, start, begins_clause, match.label.only_read)
        for end, named in self._slot("target", start, DEPTH, top=True):
            yield ParsedPart(end, "mention", (("target", named),), _MENTION, start, begins_clause)
        turned = (
            _WHERE_AT_TURN
            if begins_clause and self.phase == "navigation" and self.keys[start] in self.parser.turns
            else 0.0
        )
        for end, wheres in self._slot("where", start, DEPTH, top=True):
            cost = _WHERE + _WHERE_MORE * (_count(wheres) - 1) + turned
            yield ParsedPart(end, "where", (("where", wheres),), cost, start, begins_clause)

    def _is_usual(self, match: Match) -> bool:
        kind = match.label.key.removesuffix(BARE).rpartition(" ")[2]
        if kind == "past" and self._is_nameless(match):
            return False
        return kind not in self.parser.noun_phrase_parser.kinds or all(
            named.kind in (kind, "") for slot, named in match.bound if slot == "thing" and isinstance(named, NounPhrase)
        )

    @staticmethod
    def _is_nameless(match: Match) -> bool:
        """Return whether a match contains a thing without a kind ("another one")."""
        named = [value for _, value in match.bound if isinstance(value, NounPhrase)]
        return any(not each.kind and not each.reference for each in named)

    def _slot(self, slot: str, at: int, depth: int, *, top: bool) -> list[tuple[int, object]]:
        key = (slot, at, depth, top)
        if key not in self._memo:
            self._memo[key] = self._read_slot(slot, at, depth, top=top)
        return self._memo[key]

    def _read_slot(self, slot: str, at: int, depth: int, *, top: bool) -> list[tuple[int, object]]:
        parser = self.parser
        if slot in parser.books:
            return list(parser.books[slot].at(self.keys, at))
        if slot == "where":
            return [(end, wheres) for end, wheres in self._wheres(at, depth, top=top)]
        if slot == "joined":
            return list(parser.noun_phrase_parser.read_joined(self.keys, at, parser.conjunctions))
        if slot in ("thing", "other"):
            # The automaton tries the last one first: a plain noun phrase rather than one with a relation.
            return [*self._located_things(parser.nested, at, depth, top=False), *self._noun_phrases_at(at)]
        if slot in ("wall", "holder"):
            return [
                (end, named)
                for end, named in self._noun_phrases_at(at)
                if isinstance(named, NounPhrase)
                and (named.kind == "wall" if slot == "wall" else parser.noun_phrase_parser.is_collectible(named))
            ]
        if slot in ("landmark", "further", "detail"):
            return [
                (end, named)
                for end, named in self._slot("thing", at, depth, top=False)
                if isinstance(named, NounPhrase)
                and (named.kind or (slot == "further" and named.colour and not named.look))
                and not (named.kind and parser.noun_phrase_parser.is_collectible(named))
            ]
        if slot == "target":
            found = [*self._noun_phrases_at(at), *self._located_things(parser.attached, at, depth, top=True)]
            return [
                (end, named)
                for end, named in found
                if isinstance(named, NounPhrase) and parser.noun_phrase_parser.is_collectible(named)
            ]
        numbers = {"pair": ("two",) if self.written_only else ("two", "several"), "several": ("several",)}.get(slot)
        return [
            (end, named)
            for end, named in self._noun_phrases_at(at)
            if numbers is None or (isinstance(named, NounPhrase) and named.number in numbers)
        ]

    def unparsed_things(self, start: int, end: int, known: set[str]) -> Iterator[NounPhrase]:
        """Yield street things named between two words, the longest name at each place, except those of known kinds."""
        at = start
        while at < end:
            found = [
                (to, named) for to, named in self._noun_phrases_at(at) if to <= end and isinstance(named, NounPhrase)
            ]
            at, named = max(found, key=lambda each: each[0], default=(at + 1, None))
            if named is None or named.reference or named.kind in known:
                continue
            if not self.parser.noun_phrase_parser.is_collectible(named):
                yield named

    def _noun_phrases_at(self, at: int) -> list[tuple[int, object]]:
        key = ("", at, 0, False)
        if key not in self._memo:
            self._memo[key] = list(self.parser.noun_phrase_parser.read(self.keys, at))
        return self._memo[key]

    def _located_things(self, automaton: Automaton, at: int, depth: int, *, top: bool) -> list[tuple[int, object]]:
        """Return things with relations."""
        if depth == 0:
            return []

        def read(slot: str, place: int) -> list[tuple[int, object]]:
            return self._noun_phrases_at(place) if slot == "thing" else self._slot(slot, place, depth - 1, top=top)

        found: list[tuple[int, object]] = []
        for match in automaton.find(self.keys, at, read, self._excluded):
            bound = dict(match.bound)
            thing, where = bound["thing"], bound.get("where", ())
            assert isinstance(thing, NounPhrase)
            assert isinstance(where, tuple)
            found.append((match.end, replace(thing, where=where)))
        return found

    def _wheres(self, at: int, depth: int, *, top: bool) -> list[tuple[int, tuple[RelationPhrase, ...]]]:
        found = list(self._relations_at(at, depth))
        longer = list(found)
        for _ in range(2):
            longer = [
                (end, (*wheres, *placed))
                for before, wheres in longer
                for after in self._joins_at(before, top=top)
                for end, placed in self._relations_at(after, depth, is_joined=after > before)
            ]
            longer = list(dict.fromkeys(longer))
            found += longer
        return found

    def _joins_at(self, at: int, *, top: bool) -> Iterator[int]:
        """Yield where a further relation may begin; in free texts also at `at` ("in the road just past the tree")."""
        yield from (join.end for join in self.parser.joins[top].find(self.keys, at, lambda *_: ()))
        if top and not self.written_only:
            yield at

    def _relations_at(
        self, at: int, depth: int, *, is_joined: bool = True
    ) -> list[tuple[int, tuple[RelationPhrase, ...]]]:
        """Return (end, relations) pairs: one relation, or one to each of two things that share a noun."""
        key = (at, depth, is_joined)
        if key not in self._related:
            self._related[key] = self._read_relations(at, depth, is_joined=is_joined)
        return self._related[key]

    def _read_relations(self, at: int, depth: int, *, is_joined: bool) -> list[tuple[int, tuple[RelationPhrase, ...]]]:
        def read(slot: str, place: int) -> list[tuple[int, object]]:
            if slot == "where":  # Of the landmark: "behind placed".
                return self._slot(slot, place, depth - 1, top=False) if depth > 0 else []
            return self._slot(slot, place, depth, top=False)

        found: list[tuple[int, tuple[RelationPhrase, ...]]] = []
        matches = [
            match
            for match in self.parser.relations.find(self.keys, at, read, self._excluded)
            if not (match.label.only_read and self.written_only) and (is_joined or not match.label.main_only)
        ]
        written = {match.end for match in matches if not match.label.only_read}
        for match in matches:
            if match.label.only_read and match.end in written:
                continue
            bound = dict(match.bound)
            relation, _, kind = match.label.key.partition(" ")
            exactly = not self.parser.exact_slots.isdisjoint(bound)
            things = bound_things(bound, kind, is_between=relation == "between")
            placed = bound.get("where")
            if isinstance(placed, tuple):
                things = tuple(replace(thing, where=(*thing.where, *placed)) for thing in things)
            each = [(thing,) for thing in things] if relation != "between" else [things]
            found.append((match.end, tuple(RelationPhrase(relation, about, exactly) for about in each)))
        return list(dict.fromkeys(found))


def _more_wheres(match: Match) -> int:
    return sum(_count(value) - 1 for slot, value in match.bound if slot == "where")


def _count(wheres: object) -> int:
    return len(wheres) if isinstance(wheres, tuple) else 1
