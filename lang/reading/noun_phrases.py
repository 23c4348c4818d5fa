"""Parser of noun phrases: a noun with adjectives in any order."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from arramon_lang.grammar import Grammar
from arramon_lang.reading.matching import OPTIONAL, SplitWords
from arramon_lang.reading.naming_words import DESCRIBING, PATTERNED, PLURAL, NamingWords, WordSense
from arramon_lang.reading.parsed_phrases import OWN, PLAIN, PRONOUN, SAME, NounPhrase

_JOINED_WITHIN = 5
"""Maximum distance in words of the conjunction from the start of two noun phrases that share a noun."""

_DIVIDED_WITHIN = 5
"""Maximum number of words inside a divided noun."""

_CORNER, _OWNERS = "building_corner", ("building", "shop_sign")
"""Kind of a corner identified by its building, and kinds of things that have such corners."""


class NounPhraseParser:
    """Parser of one language's noun phrases.

    Args:
        grammar: the language's grammar.
        lexicon: content of its `lexicon.toml`, whose words for collectibles are recognised too.
        split: splits a text into comparison keys.
        conjunctions: words that join two adjectives ("white and black").

    Attributes:
        known_words: the parser's whole vocabulary; unknown words may precede a noun ("the rusty barrel").
    """

    def __init__(
        self,
        grammar: Grammar,
        lexicon: Mapping[str, Any],
        split: SplitWords,
        conjunctions: frozenset[str] = frozenset(),
    ) -> None:
        self._words = NamingWords(grammar, lexicon, split)
        self._book = self._words.book
        self._joining = conjunctions | {","}
        self._grammar_kinds = frozenset(grammar.nouns)
        self.known_words: frozenset[str] = frozenset()

    @property
    def kinds(self) -> frozenset[str]:
        """All kinds that have nouns."""
        return self._grammar_kinds

    @property
    def vocabulary(self) -> set[str]:
        """All words of noun phrases."""
        return self._words.vocabulary

    def borrow(self, other: "NounPhraseParser") -> None:
        """Add the nouns, adjectives and determiners of another language, which texts of this one may use."""
        self._words.borrow(other._words)
        self.known_words |= other.vocabulary

    def phrases(self) -> Iterator[tuple[str, ...]]:
        """Yield the fixed phrases of nouns and adjectives."""
        return (keys for keys, _ in self._book.entries())

    def describes(self, key: str) -> bool:
        """Return whether a word by itself is a colour or a look, or a noun with a look."""
        return self._words.describes(key)

    def is_collectible(self, named: NounPhrase) -> bool:
        """Return whether a noun phrase names a collectible's kind, or attributes without a kind."""
        return named.kind in self._words.collectibles and bool(named.kind or named.colour or named.look)

    def read(self, keys: Sequence[str], start: int) -> list[tuple[int, NounPhrase]]:
        """Return (end, noun phrase) pairs for all noun phrases that begin at `keys[start]`."""
        found = [*self._read_whole(keys, start), *self._read_divided(keys, start)]
        owns = any(True for _ in self._words.own.at(keys, start))
        corners = (corner for end, named in found for corner in self._corners(keys, end, named, owns=owns))
        ends = {end for end, named in found if named.kind == _CORNER or (named.kind == "corner" and named.which)}
        return [*found, *(corner for corner in corners if owns or corner[0] not in ends)]

    def _corners(
        self, keys: Sequence[str], end: int, named: NounPhrase, *, owns: bool
    ) -> Iterator[tuple[int, NounPhrase]]:
        """Yield a corner with its building: "corner of the bank", "the bank corner", "its corner"."""
        if named.kind == "corner":
            if owns:
                yield end, replace(named, kind=_CORNER, reference=OWN)
            for at, _ in self._words.of.at(keys, end):
                for after, owner in self._read_whole(keys, at):
                    if owner.kind in _OWNERS:
                        yield after, replace(named, kind=_CORNER, look=owner.look, colour=owner.colour)
        elif named.kind in _OWNERS:
            for after, word in self._words.nouns(keys, end):
                if word.value == "corner":
                    yield after, replace(named, kind=_CORNER, number="")

    def _read_divided(self, keys: Sequence[str], start: int) -> Iterator[tuple[int, NounPhrase]]:
        """Yield noun phrases with adjectives inside the noun, parsed as if the adjectives preceded it."""
        for at, noun in self._words.divided.at(keys, start):
            assert isinstance(noun, tuple)
            tail = noun[at - start :]
            for place in range(at + 1, min(at + _DIVIDED_WITHIN, len(keys) - len(tail)) + 1):
                if tuple(keys[place : place + len(tail)]) == tail:
                    size = place - at + len(noun)
                    after = place + len(tail)
                    for end, named in self._read_whole((*keys[at:place], *noun, *keys[after:]), 0):
                        if end >= size:
                            yield after + end - size, named

    def _read_whole(self, keys: Sequence[str], start: int) -> list[tuple[int, NounPhrase]]:
        """Return noun phrases, with the longest adjectives or, if these do not suit the noun, with shorter ones."""
        longest, is_unsuited = self._read_adjectives(keys, start, shortest=False)
        if not is_unsuited:
            return longest
        # "लाल बिंदी वाला कटोरा": a red dot is a banner's, but red and dotted are a bowl's.
        shorter = dict(self._read_adjectives(keys, start, shortest=True)[0])
        return [
            (end, shorter[end] if end in shorter and _says_more_than(shorter[end], named) else named)
            for end, named in longest
        ]

    def _read_adjectives(
        self, keys: Sequence[str], start: int, *, shortest: bool
    ) -> tuple[list[tuple[int, NounPhrase]], bool]:
        """Return noun phrases with the longest or the shortest adjectives, and whether some do not suit a noun."""
        is_unsuited = False
        at, reference, another = start, PLAIN, False
        for end, word in self._words.at(self._book, keys, start):
            if word.role == "pronoun":
                return [(end, NounPhrase("", reference=PRONOUN))], False
            if word.role in ("determiner", "same", "another"):
                at, reference, another = end, SAME if word.role == "same" else PLAIN, word.role == "another"
                break
        found: dict[tuple[int, NounPhrase], None] = {}
        described: list[tuple[WordSense, ...]] = []
        joined = False
        while True:
            words = list(self._words.at(self._book, keys, at))
            if not words and described and keys[at : at + 1] and keys[at] in self._joining:
                joined, at = True, at + 1  # "the white and black mug"
                words = [each for each in self._words.at(self._book, keys, at) if each[1].role in DESCRIBING]
            for end, word in words:
                if word.role == "noun" and (not joined or self._is_described(word.value, described)):
                    named = self._with_noun(keys, at, end, word, described, reference)
                    found.update((each, None) for each in _other_than_mentioned(named, another=another))
                    is_unsuited |= any(not any(self._words.suits(w, word.value) for w in group) for group in described)
            nouns = [end for end, word in words if word.role == "noun" and not word.look]
            # "Blue booth" is one noun, not an adjective before another noun.
            adjectives = [(end, word) for end, word in words if word.role in DESCRIBING and end > max(nouns, default=0)]
            if not adjectives and not words and at > start and self._is_unknown_adjective(keys, at):
                at += 1
                continue
            if not adjectives:
                return list(found) or self._without_noun(at, described, another=another), is_unsuited
            at = adjectives[-1 if shortest else 0][0]
            described.append(tuple(word for end, word in adjectives if end == at))

    def _is_described(self, kind: str, described: Sequence[tuple[WordSense, ...]]) -> bool:
        """Return whether a kind is a collectible's and all adjectives suit it."""
        return kind in self._words.collectibles and all(
            any(self._words.suits(w, kind) for w in group) for group in described
        )

    def _is_unknown_adjective(self, keys: Sequence[str], at: int) -> bool:
        """Return whether an unknown word precedes a word of the noun phrase."""
        if not self.known_words or at >= len(keys) or keys[at] in self.known_words or keys[at] in OPTIONAL:
            return False
        return any(True for _ in self._words.at(self._book, keys, at + 1))

    def _without_noun(
        self, end: int, described: Sequence[tuple[WordSense, ...]], *, another: bool
    ) -> list[tuple[int, NounPhrase]]:
        """Return a noun phrase that consists of a determiner or an ordinal: "over another", "over a second"."""
        which = next((word.value for group in described for word in group if word.role == "which"), "")
        if another and not described:
            return [(end, NounPhrase("", which="another"))]
        return [(end, NounPhrase("", which=which))] if len(described) == 1 and which in ("second", "third") else []

    def read_joined(
        self, keys: Sequence[str], start: int, conjunctions: frozenset[str]
    ) -> list[tuple[int, tuple[NounPhrase, NounPhrase]]]:
        """Return pairs of noun phrases that share a noun ("the brick and wooden walls") and begin at `keys[start]`."""
        found: list[tuple[int, tuple[NounPhrase, NounPhrase]]] = []
        if any(
            word.role in ("modifier", "two") for _, word in self._words.at(self._book, keys, start)
        ):  # "both the brick and ..."
            found += self.read_joined(keys, start + 1, conjunctions)
        for at in range(start + 1, min(start + _JOINED_WITHIN, len(keys))):
            if keys[at] not in conjunctions:
                continue
            for end, second in self.read(keys, at + 1):
                noun = next(
                    (n for n in range(end - 1, at, -1) if any(to == end for to, _ in self._words.nouns(keys, n))), end
                )
                first = [
                    named
                    for to, named in self.read((*keys[start:at], *keys[noun:end]), 0)
                    if to == at - start + end - noun
                ]
                if at + 1 < noun < end and first and first[0] != second:
                    found.append((end, (replace(first[0], number=""), replace(second, number=""))))
        return found

    def _with_noun(
        self,
        keys: Sequence[str],
        at: int,
        end: int,
        noun: WordSense,
        described: Sequence[tuple[WordSense, ...]],
        reference: str,
    ) -> Iterator[tuple[int, NounPhrase]]:
        kind = noun.value
        patterned = any(word.role == "look" and word.kind == "collectible" for group in described for word in group)
        if kind == PATTERNED or (patterned and tuple(keys[at:end]) in self._words.patterned):
            if not patterned:
                return
            kind = self._words.patterned[tuple(keys[at:end])]
        if any(self._is_another_thing(group, kind) for group in described):
            return
        if kind == "corner" and any(w.role == "look" and w.kind == "building" for group in described for w in group):
            kind = _CORNER  # "The brick corner."
        if kind == "building" and (shop := self._shop(described)):
            kind, noun = "shop_sign", replace(noun, look=shop)
        attributes = {"look": noun.look, "colour": "", "which": "", "two": "", "several": ""}
        for group in described:
            suiting = [word for word in group if self._words.suits(word, kind)] or ([] if kind else list(group))
            if suiting:
                word = min(suiting, key=lambda each: (DESCRIBING.index(each.role), each.kind != kind))
                attributes[word.role] = word.value
        after = [
            (to, word.value)
            for to, word in self._words.at(self._words.after, keys, end)
            if self._words.suits(word, kind)
        ]
        if after:
            end, attributes["look"] = after[0]
        number = attributes["two"] or attributes["several"] or ("several" if noun.kind == PLURAL else "")
        named = NounPhrase(
            kind, attributes["colour"], attributes["look"], attributes["which"], (), reference, number, noun.arms
        )
        yield end, named
        if kind in self._words.collectibles:
            yield from self._described_behind(keys, end, named)

    def _shop(self, described: Sequence[tuple[WordSense, ...]]) -> str:
        """Return the shop whose building is described ("the brown cinema building"), or ""."""
        return next((w.value for group in described for w in group if w.role == "look" and w.kind == "shop_sign"), "")

    def _described_behind(self, keys: Sequence[str], at: int, named: NounPhrase) -> Iterator[tuple[int, NounPhrase]]:
        """Yield a collectible with adjectives after its noun: "the bucket: blue, striped", "the TV, the brown one"."""
        attributes: dict[str, str] = {}
        end = at
        while at < len(keys):
            words = [each for each in self._words.at(self._book, keys, at) if self._says_more(each[1], named)]
            if words:
                end = at = words[0][0]
                attributes.update((word.role, word.value) for _, word in words[:1] if word.role != "modifier")
            elif keys[at] in self._joining or keys[at] in OPTIONAL or self._is_determiner(keys, at):
                at += 1
            else:
                break
        follows = [word for _, word in self._words.at(self._book, keys, end) if word.role == "noun"]
        if not attributes or any(getattr(named, role) for role in attributes) or any(word.value for word in follows):
            return
        ends = [to for to, word in self._words.at(self._book, keys, end) if word.role == "noun"]
        yield (
            max(ends, default=end),
            replace(named, colour=attributes.get("colour", named.colour), look=attributes.get("look", named.look)),
        )

    def _says_more(self, word: WordSense, named: NounPhrase) -> bool:
        """Return whether an adjective can describe the thing further."""
        return word.role in ("look", "colour", "modifier") and self._words.suits(word, named.kind)

    def _is_determiner(self, keys: Sequence[str], at: int) -> bool:
        return any(word.role == "determiner" for _, word in self._words.at(self._book, keys, at))

    def _is_another_thing(self, group: Sequence[WordSense], kind: str) -> bool:
        """Return whether the adjectives name a shop that the noun belongs to: "the bank's corner"."""
        return kind not in ("", "building", "zebra_crossing") and all(  # "The pharmacy crossing" is one thing.
            word.role == "look" and word.kind == "shop_sign" and not self._words.suits(word, kind) for word in group
        )


def _says_more_than(one: NounPhrase, other: NounPhrase) -> bool:
    """Return whether one of two noun phrases of a kind has more attributes."""
    count = [sum(map(bool, (each.colour, each.look, each.which))) for each in (one, other)]
    return one.kind == other.kind and count[0] > count[1]


def _other_than_mentioned(
    named: Iterator[tuple[int, NounPhrase]], *, another: bool
) -> Iterator[tuple[int, NounPhrase]]:
    for end, each in named:
        yield end, replace(each, which="another") if another else each
