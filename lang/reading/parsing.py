"""Division of one text into the parts that are understood, at the least cost."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from arramon_lang.reading.discourse import BARE, Item, things_in
from arramon_lang.reading.matching import Automaton, Match
from arramon_lang.reading.noun_phrases import NounPhrase, RelationPhrase

if TYPE_CHECKING:
    from arramon_lang.reading.reader import Reader

DEPTH = 2
"""Maximum nesting of landmarks described by landmarks."""

_ITEM, _WHERE, _WHERE_MORE, _MENTION, _FILLER, _UNKNOWN = 0.2, 0.28, 0.37, 0.8, 0.06, 1.0
"""Costs of reading a clause, a relation alone, each further one joined to it, or a thing alone; of skipping a joining
word, and any other word."""

_SAID = 0.01
"""By how much a clause that is only read costs less for each slot that it fills: one that says more is preferred."""

_WHERE_JOINED = 0.08
"""Extra cost of each further relation that is joined to one within a clause that is only read."""

_TURNED = 0.35
"""Extra cost of a relation alone where a turn may begin: "left to the planter" is no place to the left of it."""

_ALSO, _AMID, _UNUSUAL, _NAMELESS = 0.05, 0.3, 0.1, 0.02
"""Extra costs of a clause that is only read, of a main clause that begins after other words, of one about a thing
of another kind than its pattern is for, and about a thing of no kind where another pattern says the kind."""


@dataclass(slots=True)
class TextParser:
    """One text being read, with a memo of what was found at each index.

    Attributes:
        written_only: whether patterns that are only read are left out.
    """

    reader: "Reader"
    keys: tuple[str, ...]
    phase: str
    written_only: bool = False
    _memo: dict[tuple[str, int, int, bool], list[tuple[int, object]]] = field(default_factory=dict)
    _related: dict[tuple[int, int, bool], list[tuple[int, tuple[RelationPhrase, ...]]]] = field(default_factory=dict)
    _closed: list[frozenset[str]] = field(init=False)

    def __post_init__(self) -> None:
        self._closed = [self.reader.closed_slots(key) for key in (*self.keys, None)]

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
        items: list[tuple[int, Item]] = []
        at = 0
        while at < size:
            chosen = best[at][1]
            if chosen is not None:
                last = items[-1][1] if items else None
                if chosen.label == "where" and last is not None and last.label == "where" and last.end == at:
                    chosen = replace(chosen, fresh=last.fresh)
                if last is not None and self._is_joined(last.end, at):
                    chosen = replace(chosen, joined=True)
                items.append((at, chosen))
            at = chosen.end if chosen is not None else at + 1
        return items

    def is_covered_by(self, items: list[tuple[int, Item]]) -> bool:
        """Return whether clauses and joining words are all that the text consists of, with the object to pick up."""
        at, is_found = 0, self.phase == "assembly"
        for start, item in items:
            if item.label == "mention" or (item.label == "where" and not is_found) or self._skips_words(at, start):
                return False
            at, is_found = item.end, is_found or item.label.startswith("target")
        return is_found and not self._skips_words(at, len(self.keys))

    def _is_joined(self, start: int, end: int) -> bool:
        """Return whether nothing but commas and "and" stands between two words."""
        return start < end and all(key == "," or key in self.reader.conjunctions for key in self.keys[start:end])

    def _skips_words(self, start: int, end: int) -> bool:
        return any(key not in self.reader.fillers for key in self.keys[start:end])

    def _items_at(self, start: int) -> Iterable[Item]:
        automaton = self.reader.clauses[self.phase]
        amid = start > 0 and self.keys[start - 1] not in self.reader.fillers
        fresh = start == 0 or self.keys[start - 1] in self.reader.openers

        def read(slot: str, at: int) -> list[tuple[int, object]]:
            return self._slot(slot, at, DEPTH, top=True)

        for match in automaton.find(self.keys, start, read, self._closed):
            if (match.label.key.endswith(BARE) and not fresh) or (match.label.also and self.written_only):
                continue
            unusual = 0.0 if self._is_usual(match) else _NAMELESS if self._is_nameless(match) else _UNUSUAL
            cost = _ITEM + _ALSO * match.label.also + _AMID * (amid and match.label.main_only) + unusual
            cost += match.label.also * (_WHERE_JOINED * _more_wheres(match) - _SAID * len(match.bound))
            yield Item(match.end, match.label.key, match.bound, cost, start, fresh, match.label.also)
        for end, named in self._slot("target", start, DEPTH, top=True):
            yield Item(end, "mention", (("target", named),), _MENTION, start, fresh)
        turned = _TURNED if fresh and self.phase == "navigation" and self.keys[start] in self.reader.turns else 0.0
        for end, wheres in self._slot("where", start, DEPTH, top=True):
            cost = _WHERE + _WHERE_MORE * (_count(wheres) - 1) + turned
            yield Item(end, "where", (("where", wheres),), cost, start, fresh)

    def _is_usual(self, match: Match) -> bool:
        kind = match.label.key.removesuffix(BARE).rpartition(" ")[2]
        if kind == "past" and self._is_nameless(match):
            return False
        return kind not in self.reader.noun_phrase_reader.kinds or all(
            named.kind in (kind, "") for slot, named in match.bound if slot == "thing" and isinstance(named, NounPhrase)
        )

    @staticmethod
    def _is_nameless(match: Match) -> bool:
        """Return whether a match is about something whose kind is not said ("another one")."""
        named = [value for _, value in match.bound if isinstance(value, NounPhrase)]
        return any(not each.kind and not each.back for each in named)

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
            # The automaton tries the last one first: a plain noun phrase rather than one with a relation.
            return [*self._located_things(reader.nested, at, depth, top=False), *self._noun_phrases_at(at)]
        if slot in ("wall", "holder"):
            return [
                (end, named)
                for end, named in self._noun_phrases_at(at)
                if isinstance(named, NounPhrase)
                and (named.kind == "wall" if slot == "wall" else reader.noun_phrase_reader.is_collectible(named))
            ]
        if slot in ("landmark", "further", "detail"):
            return [
                (end, named)
                for end, named in self._slot("thing", at, depth, top=False)
                if isinstance(named, NounPhrase)
                and (named.kind or (slot == "further" and named.colour and not named.look))
                and not (named.kind and reader.noun_phrase_reader.is_collectible(named))
            ]
        if slot == "target":
            found = [*self._noun_phrases_at(at), *self._located_things(reader.attached, at, depth, top=True)]
            return [
                (end, named)
                for end, named in found
                if isinstance(named, NounPhrase) and reader.noun_phrase_reader.is_collectible(named)
            ]
        numbers = {"pair": ("two",) if self.written_only else ("two", "several"), "several": ("several",)}.get(slot)
        return [
            (end, named)
            for end, named in self._noun_phrases_at(at)
            if numbers is None or (isinstance(named, NounPhrase) and named.number in numbers)
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
        for match in automaton.find(self.keys, at, read, self._closed):
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
        """Yield where a further relation may begin; in free texts right there ("in the road just past the tree")."""
        yield from (join.end for join in self.reader.joins[top].find(self.keys, at, lambda *_: ()))
        if top and not self.written_only:
            yield at

    def _relations_at(
        self, at: int, depth: int, *, is_joined: bool = True
    ) -> list[tuple[int, tuple[RelationPhrase, ...]]]:
        """Return relations: a single one, or one to each of two things that share a noun."""
        key = (at, depth, is_joined)
        if key not in self._related:
            self._related[key] = self._read_relations(at, depth, is_joined=is_joined)
        return self._related[key]

    def _read_relations(self, at: int, depth: int, *, is_joined: bool) -> list[tuple[int, tuple[RelationPhrase, ...]]]:
        def read(slot: str, place: int) -> list[tuple[int, object]]:
            return self._slot(slot, place, depth, top=False)

        found: list[tuple[int, tuple[RelationPhrase, ...]]] = []
        matches = [
            match
            for match in self.reader.relations.find(self.keys, at, read, self._closed)
            if not (match.label.also and self.written_only) and (is_joined or not match.label.main_only)
        ]
        written = {match.end for match in matches if not match.label.also}
        for match in matches:
            if match.label.also and match.end in written:
                continue
            bound = dict(match.bound)
            relation, _, kind = match.label.key.partition(" ")
            exactly = not self.reader.exact_slots.isdisjoint(bound)
            things = things_in(bound, kind, is_between=relation == "between")
            each = [(thing,) for thing in things] if relation != "between" else [things]
            found.append((match.end, tuple(RelationPhrase(relation, about, exactly) for about in each)))
        return list(dict.fromkeys(found))


def _more_wheres(match: Match) -> int:
    return sum(_count(value) - 1 for slot, value in match.bound if slot == "where")


def _count(wheres: object) -> int:
    return len(wheres) if isinstance(wheres, tuple) else 1
