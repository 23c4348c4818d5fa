"""Chunker: finds noun phrases, relations, sides, verbs and joining words in a text."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from arramon_lang.patterns import parse, spell_out
from arramon_lang.reading.chunks.rules import load_rules
from arramon_lang.reading.matching import SplitWords
from arramon_lang.reading.noun_phrases import NounPhraseParser
from arramon_lang.reading.parsed_phrases import NounPhrase

THING, SIDE, LOOK, RELATION, VERB, YOURS = "thing", "side", "look", "relation", "verb", "yours"

STOP, THEN = "stop", "then"
"""Keys of `words` in `chunks.toml` that end a sentence or a clause."""

SIDES = ("left", "right")

Keys = tuple[str, ...]

_MAX_OWN_PLACE_WORDS = 8
"""Maximum number of words in a relation to the reader ("in front of you")."""


@dataclass(frozen=True, slots=True)
class Chunk:
    """A noun phrase, a relation, a side, a verb or another word that matters.

    Attributes:
        kind: THING, SIDE, LOOK, RELATION, VERB, YOURS (a possessive pronoun, or a relation to the
            reader), or a key of `words` in `chunks.toml`.
        start: index of its first word.
        end: index after its last word.
        value: for SIDE "left", "right", "back" or "around"; otherwise a key of `relations` or `verbs`, or a
            collectible's pattern.
        things: noun phrases of a THING: one, or two that share a noun.
        slight: whether a side is modified by "slightly".
        nominal: whether a side is named as a place ("the left side") rather than a direction.
        is_additional: whether a thing is followed by "too".
        exactly: whether a relation is called direct ("directly behind").
    """

    kind: str
    start: int
    end: int
    value: str = ""
    things: tuple[NounPhrase, ...] = ()
    slight: bool = False
    nominal: bool = False
    is_additional: bool = False
    exactly: bool = False


class Chunker:
    """Chunker of one language.

    Args:
        data: content of the language's `chunks.toml`; its comments describe the format.
        noun_phrases: parser of the language's noun phrases.
        conjunctions: words that join two things.
        split: splits a text into comparison keys.

    Attributes:
        vocabulary: all words of the phrases.
        rules: meanings of the language's relations and verbs.
    """

    def __init__(
        self,
        data: Mapping[str, Any],
        noun_phrases: NounPhraseParser,
        conjunctions: frozenset[str],
        split: SplitWords,
    ) -> None:
        self._split = split
        self._noun_phrases = noun_phrases
        self._conjunctions = conjunctions
        self.rules = load_rules(data)
        self._soft, self._own = frozenset(data.get("soft", ())), frozenset(data.get("own", ()))
        self._ignored_suffixes = tuple(data.get("suffixes", ()))
        self._relating_suffixes = tuple(data.get("relating_suffixes", ()))
        self._nouns = frozenset(noun_phrases.vocabulary)
        self._exactly = frozenset(data.get("exactly", ()))
        self._also = frozenset(data.get("also", ()))
        self._of = tuple(data["relations"].get("of", ()))
        self._sides = [(phrase, side) for side, texts in data["sides"].items() for phrase in self._phrases(texts)]
        self._nominal, self._nominal_before, self._slightly, self._slightly_behind = (
            sorted(self._phrases(data.get(key, [])), key=len, reverse=True)
            for key in ("nominal", "nominal_before", "slightly", "slightly_behind")
        )
        self._slight_more = frozenset(data.get("slight_more", ()))
        self._listed: dict[str, list[tuple[Keys, str, str]]] = {}
        for kind, table in ((VERB, self._verbs(data)), (RELATION, data["relations"]), (LOOK, data.get("looks", {}))):
            for value, texts in table.items():
                self._add(kind, value, texts)
        for kind, texts in data["words"].items():
            self._add(kind, "", texts)
        self._written_together = {split(one)[0]: split(apart) for one, apart in data.get("written_together", ())}
        unused = [each for each in self._relating_suffixes if each not in self._listed]
        if unused:
            raise ValueError(f"chunks: relating_suffixes: no relation begins with {', '.join(map(repr, unused))}")
        phrases = [phrase for listed in self._listed.values() for phrase, _, _ in listed]
        beside = (*self._nominal, *self._nominal_before, *self._slightly, *self._slightly_behind)
        words = {word for phrase in (*phrases, *beside, *(side for side, _ in self._sides)) for word in phrase}
        self.vocabulary = frozenset(words | self._soft | self._own | set(self._written_together))

    def chunks(self, keys: Sequence[str]) -> list[Chunk]:
        """Return the chunks of a text in order; words that belong to none are skipped."""
        keys = [part for key in keys for part in self._written_together.get(key) or self._parts(key)]
        found: list[Chunk] = []
        at = 0
        while at < len(keys):
            chunk = self._longest(keys, at)
            if chunk is not None:
                found.append(chunk)
            at = at + 1 if chunk is None else chunk.end
        return found

    def phrases(self) -> Iterator[Keys]:
        """Yield the phrases of relations, verbs, sides and joining words."""
        yield from (phrase for listed in self._listed.values() for phrase, _, _ in listed)
        yield from (phrase for phrase, _ in self._sides)
        yield from self._nominal

    def split_suffix(self, key: str) -> Keys | None:
        """Return a noun and the relation that is its suffix ("చెట్టుకి" is "చెట్టు", "to"); None for other words."""
        for suffix in self._relating_suffixes:
            noun = key.removesuffix(suffix)
            if noun != key and noun in self._nouns:
                return noun, suffix
        return None

    def _parts(self, key: str) -> Keys:
        """Return a word without an ignored ending, or the two parts of one with a relating suffix."""
        ignored = next((each for each in self._ignored_suffixes if key.endswith(each)), "")
        return self.split_suffix(key) or (key.removesuffix(ignored),)

    def _longest(self, keys: Sequence[str], at: int) -> Chunk | None:
        words = list(self._words(keys, at))
        is_thing = not self.rules.has_prepositions or all(word.kind != RELATION for word in words)
        found: list[Chunk] = [
            *self._side(keys, at),
            *words,
            *(self._things(keys, at) if is_thing else ()),
            *self._own_places(keys, at),
        ]
        found.sort(key=lambda chunk: (chunk.end, self.rules.has_prepositions and _refers_back(chunk)), reverse=True)
        longest = found[0] if found else None
        if longest is None or longest.kind == THING:
            return longest
        return replace(longest, exactly=not self._exactly.isdisjoint(keys[max(at - 1, 0) : longest.end]))

    def _side(self, keys: Sequence[str], start: int) -> Iterator[Chunk]:
        at = start
        while at < len(keys) and keys[at] in self._own:
            at += 1
        placed = self._size(self._nominal_before, keys, at)
        slight = self._size(self._slightly, keys, at + placed)
        at += placed + slight
        while at < len(keys) and ((slight and keys[at] in self._slight_more) or keys[at] in self._own):
            at += 1
        end, side = max((self._end(phrase, keys, at), side) for phrase, side in self._sides)
        if end:
            nominal = self._size(self._nominal, keys, end)
            more = self._size(self._slightly_behind, keys, end + nominal)
            more = 0 if self._begins_side(keys, end + nominal + more) else more  # "Left, slightly right at the tree."
            is_nominal = bool(placed or nominal)
            yield Chunk(SIDE, start, end + nominal + more, side, slight=bool(slight or more), nominal=is_nominal)

    def _begins_side(self, keys: Sequence[str], at: int) -> bool:
        return any(self._end(phrase, keys, at) for phrase, _ in self._sides)

    def _size(self, phrases: Sequence[Keys], keys: Sequence[str], at: int) -> int:
        """Return the length of the longest of the phrases that begins at `at`, 0 if none does."""
        return next((len(phrase) for phrase in phrases if tuple(keys[at : at + len(phrase)]) == phrase), 0)

    def _words(self, keys: Sequence[str], at: int) -> Iterator[Chunk]:
        for phrase, kind, value in self._listed.get(keys[at], ()):
            end = self._end(phrase, keys, at)
            if end:
                yield Chunk(kind, at, end, value)

    def _own_places(self, keys: Sequence[str], at: int) -> Iterator[Chunk]:
        """Yield relations to the reader, expressed by a possessive pronoun: "before you", "between you and it"."""
        if keys[at] in self._own:
            yield Chunk(YOURS, at, at + 1)
            for of in self._of:
                for chunk in self._words((of, *keys[at + 1 : at + _MAX_OWN_PLACE_WORDS]), 0):
                    if chunk.kind == RELATION and chunk.end > 1:
                        yield Chunk(YOURS, at, at + chunk.end, chunk.value)

    def _things(self, keys: Sequence[str], at: int) -> Iterator[Chunk]:
        named = [
            (end, (one,)) for end, one in self._noun_phrases.read(keys, at) if not (one.reference and not one.kind)
        ]
        joins = keys[at] not in self._own and not (self.rules.has_prepositions and self._are_joined_wholes(keys, named))
        joined = self._noun_phrases.read_joined(keys, at, self._conjunctions) if joins else []
        for end, things in (*named, *joined):
            if things[0].kind or self._noun_phrases.is_collectible(things[0]):
                yield Chunk(THING, at, end, things=things, is_additional=not self._also.isdisjoint(keys[end : end + 2]))

    def _are_joined_wholes(self, keys: Sequence[str], named: Iterable[tuple[int, object]]) -> bool:
        """Return whether "and" follows a complete noun phrase: "the bank and two crossings" share no noun."""
        return any(keys[end : end + 1] and keys[end] in self._conjunctions for end, _ in named)

    def _end(self, phrase: Keys, keys: Sequence[str], at: int) -> int:
        """Return the index after the phrase, which may be interrupted by soft words; 0 if it is not at `at`."""
        for word in phrase:
            while at < len(keys) and keys[at] != word and keys[at] in self._soft and word != phrase[0]:
                at += 1
            if at >= len(keys) or keys[at] != word:
                return 0
            at += 1
        return at

    def _verbs(self, data: Mapping[str, Any]) -> Mapping[str, Sequence[str]]:
        endings, vowels = data.get("endings", {"consonant": [""], "vowel": [""]}), data.get("vowels", ())
        return {
            name: [
                *entry.get("words", ()),
                *(
                    stem + ending
                    for stem in entry.get("stems", ())
                    for ending in endings["vowel" if stem.endswith(tuple(vowels)) else "consonant"]
                ),
            ]
            for name, entry in data["verbs"].items()
        }

    def _phrases(self, texts: Iterable[str]) -> list[Keys]:
        return [self._split(text) for each in texts for text in spell_out(parse(each).body, {})]

    def _add(self, kind: str, value: str, texts: Iterable[str]) -> None:
        for phrase in self._phrases(texts):
            entries = self._listed.setdefault(phrase[0], [])
            if (phrase, kind, value) not in entries:
                entries.append((phrase, kind, value))


def _refers_back(chunk: Chunk) -> bool:
    return any(named.reference for named in chunk.things)
