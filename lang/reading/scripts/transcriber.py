"""Transcription of texts in Latin letters, or with English words, into a language's own script and vocabulary."""

import re
from collections import defaultdict
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise, product
from typing import Any

from arramon_lang.reading.noun_phrases import NounPhraseParser
from arramon_lang.reading.parsed_phrases import PRONOUN
from arramon_lang.reading.scripts.sounds import Sounds, distance
from arramon_lang.tokens import LATIN

_NEAR = 0.75
"""Maximum distance at which a typed word is taken for a word of the vocabulary."""

_NEAR_PER_SOUND = 0.1
"""The same for each letter of the typed word's sound: short words must be nearer."""

_NEIGHBOURS = 0.1
"""Discount of a word that a phrase of the language has beside the word before or after it."""

_LETTERS = 0.02
"""Cost of each letter h that only one of two spellings has: of words that sound alike, the nearer in letters wins."""

_LOAN = 0.2
"""Maximum distance of a foreign word in the language's own script, and of a word that is surely the language's own."""

_UNUSUAL = 0.03
"""Cost of words that are only read."""

_LONG_LOAN, _LONG = 0.3, 4
"""The same for a foreign word of so many letters."""

_MAX_PHRASE = 3
"""Maximum number of words of an entry of [senses] and [short]."""

_MAX_CHOICES = 5
"""Maximum number of words that are considered for one typed word."""

_IS_LATIN = re.compile(f"[{LATIN}]+(?:['’][{LATIN}]+)*$")


@dataclass(frozen=True, slots=True)
class Choice:
    """A word that a typed word may stand for, and how unlike it sounds."""

    text: str
    cost: float


class Transcriber:
    """Transcribes words of one language's texts.

    Args:
        data: content of the language's `latin.toml`.
        vocabulary: words of the language in its own script.
        usual: those of them that texts are written with: preferred to others that sound alike.
        phrases: phrases of several words, whose neighbouring words decide between words that sound alike.
        nouns: noun phrases of the language itself.
        borrowed: noun phrases of the language from which words are borrowed; they are left as they are.
        expand: corrects typing errors of that language, and writes abbreviations in full.
    """

    def __init__(
        self,
        data: Mapping[str, Any],
        vocabulary: Iterable[str],
        usual: Collection[str],
        phrases: Iterable[Sequence[str]],
        nouns: NounPhraseParser,
        borrowed: NounPhraseParser,
        expand: Callable[[str], tuple[str, ...]],
    ) -> None:
        self._sounds = Sounds(data)
        vocabulary = frozenset(vocabulary)
        self._latin = frozenset(filter(_IS_LATIN.match, vocabulary))
        self._own = frozenset(word for word in vocabulary if not _IS_LATIN.match(word) and word[0].isalpha())
        self._nouns, self._own_nouns, self._usual = nouns, frozenset(nouns.vocabulary), frozenset(usual)
        self._borrowed, self._foreign, self._expand = borrowed, frozenset(borrowed.vocabulary), expand
        self._having = frozenset(data["having"])
        self._rewriting = [(re.compile(rule["pattern"]), rule["words"]) for rule in data["rewriting"]]
        self._short: Mapping[str, str] = data["short"]
        self._senses: Mapping[str, str] = data["senses"]
        self._pairs = {pair for phrase in phrases for pair in pairwise(phrase)}
        self._by_first: dict[str, list[tuple[str, str]]] = defaultdict(list)
        for word in sorted(self._own):
            for sound in self._sounds.own(word):
                self._by_first[_first(sound)].append((sound, word))
        self._loans: dict[str, list[tuple[tuple[str, ...], str]]] = defaultdict(list)
        for word, spellings in data["loans"].items():
            for spelling in spellings:
                for parts in self._all_sounds(spelling.split()):
                    self._loans[_first(parts[0])].append((parts, word))
        self._loan_words = frozenset(data["loans"])
        self._known = frozenset(data["known"])
        self._choices: dict[str, tuple[Choice, ...]] = {}
        self._borrowings: dict[tuple[str, ...], str | None] = {}

    def is_needed(self, keys: Sequence[str]) -> bool:
        """Return whether a text has words in Latin letters, or foreign ones in the language's own letters."""
        return any(_IS_LATIN.match(key) and key not in self._latin for key in keys) or any(
            self.is_unknown(key) and self._borrowing((key,)) for key in keys
        )

    def is_unknown(self, key: str) -> bool:
        """Return whether a word in the language's own letters is not in its vocabulary."""
        return not (key in self._own or key in self._known or _IS_LATIN.match(key)) and key[0].isalpha()

    def is_own(self, key: str) -> bool:
        """Return whether a word in Latin letters sounds like a word of the language, or is a short form of one."""
        return key in self._short or any(choice.cost <= _LOAN for choice in self.choices(key))

    def is_short(self, key: str) -> bool:
        """Return whether a word is a usual short form of one of the language's."""
        return bool(self._short.get(key))

    def is_borrowed(self, key: str) -> bool:
        """Return whether a word is a foreign noun, adjective or loan, which sentences of the language use."""
        return key not in self._short and (
            key in self._loan_words or (key in self._foreign and key not in self._senses)
        )

    def has_sense(self, key: str) -> bool:
        """Return whether another foreign word is understood within sentences of the language."""
        return key in self._senses

    def is_understood(self, key: str) -> bool:
        """Return whether sentences of the language may contain a word in Latin letters."""
        return self.is_borrowed(key) or self.has_sense(key) or self.is_own(key)

    def transcribe(self, keys: Sequence[str]) -> str:
        """Return a text in which words in Latin letters are the language's own or, if borrowed, as they are."""
        keys = [part for key in keys for part in self._expanded(key)]
        found: list[str] = []
        at = 0
        while at < len(keys):
            size, words = self._phrase(keys, at)
            if not size:
                size, words = 1, [self._best(keys, at, found[-1] if found else "")]
            words = [word for text in words for word in text.split()]
            if words and words[0] in self._having and found and self._borrowed.describes(found[-1]):
                words = words[1:]  # "Triangle wala banner" is "triangle banner".
            found += words
            at += size
        text = " ".join(found)
        for pattern, replacement in self._rewriting:
            text = pattern.sub(replacement, text)
        return text

    def _expanded(self, key: str) -> tuple[str, ...]:
        """Return a word, or the foreign nouns and adjectives that it is short for or misspelt for."""
        if not _IS_LATIN.match(key) or key in self._foreign or key in self._senses or key in self._short:
            return (key,)
        words = self._expand(key)
        return words if self._foreign.issuperset(words) and not self.is_own(key) else (key,)

    def choices(self, key: str) -> tuple[Choice, ...]:
        """Return the words of the language that a typed word may stand for, the nearest first."""
        if key not in self._choices:
            typed = self._sounds.typed(key)
            limit = min(_NEAR, _NEAR_PER_SOUND * len(typed))
            nearest: dict[str, float] = {}
            for sound, word in self._by_first.get(_first(typed), ()):
                cost = distance(typed, sound)
                if cost <= limit:
                    cost += self._unlike_letters(key, word) + _UNUSUAL * (word not in self._usual)
                    nearest[word] = min(cost, nearest.get(word, cost))
            ranked = sorted(nearest.items(), key=lambda each: (each[1], len(each[0]), each[0]))
            self._choices[key] = tuple(Choice(word, cost) for word, cost in ranked[:_MAX_CHOICES])
        return self._choices[key]

    def _unlike_letters(self, key: str, word: str) -> float:
        """Return a small cost for spellings that differ in aspirates or in length, of words that sound alike."""
        spelt = self._sounds.spelt(word)
        return _LETTERS * abs(key.count("h") - spelt.count("h")) + _LETTERS / 4 * abs(len(key) - len(spelt))

    def _phrase(self, keys: Sequence[str], at: int) -> tuple[int, list[str]]:
        """Return the number of words at `at` that belong together, and what they are in the language."""
        if not _IS_LATIN.match(keys[at]):
            return self._own_phrase(keys, at)
        for size in range(_MAX_PHRASE, 1, -1):
            phrase = " ".join(keys[at : at + size])
            for table in (self._short, self._senses):
                if phrase in table and len(keys) >= at + size:
                    return size, [table[phrase]]
        end = self._end_of_thing(keys, at)
        if end > at + 1 or (end and keys[at] not in self._senses and keys[at] not in self._short):
            return end - at, list(keys[at:end])
        return 0, []

    def _own_phrase(self, keys: Sequence[str], at: int) -> tuple[int, list[str]]:
        """Return words in the language's own letters, foreign ones as they are written in their own."""
        end = max((end for end, thing in self._nouns.read(keys, at) if thing.kind), default=0)
        if end and self._own_nouns.issuperset(keys[at:end]):
            return end - at, list(keys[at:end])
        if keys[at] in self._own and keys[at] not in self._own_nouns:
            return 1, [keys[at]]
        for size in (2, 1):
            written = tuple(keys[at : at + size])
            foreign = self._borrowing(written) if len(written) == size else None
            if foreign is not None and (foreign in self._senses or foreign in self._foreign or size > 1):
                return size, [self._senses.get(foreign, foreign)]
        return 1, [keys[at]]

    def _borrowing(self, written: tuple[str, ...]) -> str | None:
        if written not in self._borrowings:
            nearest: list[tuple[float, str]] = []
            for parts in self._all_sounds(written):
                for known, word in self._loans.get(_first(parts[0]), ()):
                    if len(known) == len(parts):
                        nearest.append((max(map(distance, parts, known)), word))
            cost, word = min(nearest, default=(_LOAN + 1.0, ""))
            limit = _LONG_LOAN if len("".join(written)) >= _LONG else _LOAN
            self._borrowings[written] = word if cost <= limit else self._plural(written)
        return self._borrowings[written]

    def _plural(self, written: tuple[str, ...]) -> str | None:
        """Return the foreign plural in -s of a loan."""
        stem = written[-1].removesuffix("स").removesuffix("्")
        singular = self._borrowing((*written[:-1], stem)) if stem and stem != written[-1] else None
        return f"{singular}s" if singular is not None and f"{singular}s" in self._foreign else None

    def _all_sounds(self, words: Sequence[str]) -> list[tuple[str, ...]]:
        return list(product(*map(self._sounds.own, words)))

    def _end_of_thing(self, keys: Sequence[str], at: int) -> int:
        """Return the index after the foreign noun phrase that begins at `at`; 0 if none does."""
        named = [end for end, thing in self._borrowed.read(keys, at) if thing.reference != PRONOUN and thing.kind]
        end = max((end for end in named if self._foreign.issuperset(keys[at:end])), default=0)
        if end > at + 1 and keys[end : end + 1] and self._is_having(keys[end]):
            end -= self._borrowed.describes(keys[end - 1])  # "Mug dots wala bowl ke paas": the dots are the bowl's.
        if not end and keys[at] in self._foreign and (keys[at] in self._loan_words or not self._own_choice(keys[at])):
            return at + 1
        return end

    def _is_having(self, key: str) -> bool:
        return key in self._having or any(choice.text in self._having for choice in self.choices(key)[:1])

    def _own_choice(self, key: str) -> bool:
        return any(choice.cost <= _LETTERS for choice in self.choices(key))

    def _best(self, keys: Sequence[str], at: int, before: str) -> str:
        """Return the word that a typed word most likely stands for, by its sound and the word before it."""
        key = keys[at]
        if not _IS_LATIN.match(key):
            return key
        following = self._following(keys, at)
        if key in self._short and not self._is_elsewhere(before, self._short[key], key, following):
            return self._short[key]
        if key in self._senses:
            return self._senses[key]
        ranked = [
            (choice.cost - _NEIGHBOURS * self._count_pairs(before, choice.text, following), number, choice.text)
            for number, choice in enumerate(self.choices(key))
        ]
        return min(ranked, default=(0.0, 0, key))[2]

    def _following(self, keys: Sequence[str], at: int) -> tuple[str, ...]:
        """Return what the next word most likely is."""
        if not keys[at + 1 : at + 2]:
            return ()
        return tuple(choice.text for choice in self.choices(keys[at + 1])[:2]) or (keys[at + 1],)

    def _count_pairs(self, before: str, word: str, following: Sequence[str]) -> int:
        """Return with how many of its neighbours, 0 to 2, a word occurs in the language's phrases."""
        return ((before, word) in self._pairs) + any((word, each) in self._pairs for each in following)

    def _is_elsewhere(self, before: str, usual: str, key: str, following: Sequence[str]) -> bool:
        """Return whether a word beside these neighbours is more likely another one than usual."""
        fitting = self._count_pairs(before, usual, following)
        return any(
            self._count_pairs(before, choice.text, following) > fitting
            for choice in self.choices(key)
            if choice.cost <= _LOAN and choice.text != usual
        )


def _first(sound: str) -> str:
    """Return a sound's first consonant, or "" if it begins with a vowel."""
    return "" if not sound or sound[0] in "aeiou" else sound[0]
