"""Words of texts in any script, and the vocabulary that a reader knows."""

import re
import unicodedata
from collections import Counter
from collections.abc import Iterable

UNKNOWN = 1
"""The number of words that are not in the vocabulary; 0 fills up texts that are shorter than others of a batch."""

_MARKS = re.compile(r"([^\w\u0900-\u097F'’-]|[\u0964\u0965])")
"""What stands alone: everything but letters, digits, Devanagari's letters and signs, apostrophes and hyphens."""


def split(text: str) -> list[str]:
    """Return a text's words and marks in order, in lower case and Unicode's NFC."""
    return _MARKS.sub(r" \1 ", unicodedata.normalize("NFC", text).lower()).split()


class Vocabulary:
    """Words with their numbers.

    Args:
        words: in order; the first has the number 2.
    """

    def __init__(self, words: Iterable[str]) -> None:
        self.words = tuple(words)
        self._numbers = {word: number for number, word in enumerate(self.words, start=UNKNOWN + 1)}

    @classmethod
    def of(cls, texts: Iterable[str], fewest: int = 2) -> "Vocabulary":
        """Return the vocabulary of all words that occur often enough in texts, the most frequent first."""
        counts = Counter(word for text in texts for word in split(text))
        return cls(
            word for word, count in sorted(counts.items(), key=lambda item: (-item[1], item[0])) if count >= fewest
        )

    def __len__(self) -> int:
        """Return how many numbers there are, those of unknown words and of filling included."""
        return len(self.words) + UNKNOWN + 1

    def numbers(self, text: str) -> list[int]:
        """Return the numbers of a text's words; at least one."""
        return [self._numbers.get(word, UNKNOWN) for word in split(text)] or [UNKNOWN]
