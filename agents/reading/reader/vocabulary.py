"""Vocabulary of the learned reader, and tokenization of texts into words in any script."""

import re
import unicodedata
from collections import Counter
from collections.abc import Iterable

from arramon_agents.reading.reader.spelling import MAX_NGRAMS, hash_ngrams

UNKNOWN = 1
"""Id of words outside the vocabulary; 0 is padding."""

MIN_OCCURRENCES = 8
"""Minimum number of times that a word occurs in the texts of a training to get an id: most rarer ones are misspelt."""

CODE_SIZE = 1 + MAX_NGRAMS
"""Length of a word's code."""

WordCode = tuple[int, ...]
"""A word for the network: its id, and the ids of its character n-grams, by which unknown words are read."""

_MARKS = re.compile(r"([^\w\u0900-\u097F'’-]|[\u0964\u0965])")
"""Characters that are tokens of their own: all but letters, digits, Devanagari signs, apostrophes and hyphens."""


def split(text: str) -> list[str]:
    """Return a text's words and punctuation marks in order, in lower case and NFC."""
    return _MARKS.sub(r" \1 ", unicodedata.normalize("NFC", text).lower()).split()


class Vocabulary:
    """Vocabulary of words with ids.

    Args:
        words: words in the order of their ids, from 2 on.
    """

    def __init__(self, words: Iterable[str]) -> None:
        self.words = tuple(words)
        self._numbers = {word: number for number, word in enumerate(self.words, start=UNKNOWN + 1)}

    @classmethod
    def of(cls, texts: Iterable[str], fewest: int = MIN_OCCURRENCES) -> "Vocabulary":
        """Return the vocabulary of all words that occur at least `fewest` times, the most frequent first."""
        counts = Counter(word for text in texts for word in split(text))
        return cls(
            word for word, count in sorted(counts.items(), key=lambda item: (-item[1], item[0])) if count >= fewest
        )

    def __len__(self) -> int:
        """Return the number of ids, including padding and the unknown word."""
        return len(self.words) + UNKNOWN + 1

    def extended(self, other: "Vocabulary") -> "Vocabulary":
        """Return a vocabulary of these words, with the same ids, and the new words of another."""
        return Vocabulary((*self.words, *(word for word in other.words if word not in self._numbers)))

    def code(self, word: str) -> WordCode:
        """Return the code of a word."""
        return (self._numbers.get(word, UNKNOWN), *hash_ngrams(word))

    def encode(self, text: str) -> list[WordCode]:
        """Return the codes of a text's words; if it has none, that of the unknown word without n-grams."""
        return [self.code(word) for word in split(text)] or [self.code("")]
