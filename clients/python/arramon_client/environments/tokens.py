"""Tokenizers: instructions as padded numbers, for learners that do not take texts."""

import hashlib
from collections.abc import Iterable, Sequence
from typing import Protocol

import numpy as np
import numpy.typing as npt

from arramon_client.words import words

PAD, END, UNKNOWN, SPECIAL = 0, 1, 2, 3
"""Numbers that stand for padding, the end of a text and an unknown word; the number of these."""


class Tokenizer(Protocol):
    """Turns texts into numbers.

    Attributes:
        name: what tells the tokenizer from others.
        size: all numbers are less than this.
        length: numbers of every text, padding included.
    """

    name: str
    size: int
    length: int

    def encode(self, text: str) -> npt.NDArray[np.int32]:
        """Return a new array of (length,) int32; what does not fit is cut off."""


class ByteTokenizer:
    """The bytes of UTF-8, numbered as in ByT5: byte + 3, then 1 for the end, then 0. It needs no vocabulary.

    Args:
        longest: bytes of the longest text.
    """

    name = "utf8-bytes"
    size = 256 + SPECIAL

    def __init__(self, longest: int) -> None:
        self.length = longest + 1

    def encode(self, text: str) -> npt.NDArray[np.int32]:
        """Return (length,) int32."""
        numbers = np.frombuffer(text.encode(), np.uint8).astype(np.int32) + SPECIAL
        return _padded(numbers, self.length)


class WordTokenizer:
    """Words, numbered in the order of a vocabulary; punctuation marks are words.

    A word is a run of letters with their combining signs and digits, in lower case. Use one tokenizer for all splits
    that an agent meets: `WordTokenizer.of` the texts that it is trained on.

    Args:
        vocabulary: the known words.
        length: words of the longest text that is not cut off, and 1 for its end.
    """

    def __init__(self, vocabulary: Sequence[str], length: int) -> None:
        self.vocabulary, self.length = tuple(vocabulary), length
        self._numbers = {word: number for number, word in enumerate(self.vocabulary, start=SPECIAL)}
        self.size = len(self.vocabulary) + SPECIAL
        digest = hashlib.sha256("\n".join(self.vocabulary).encode()).hexdigest()[:8]
        self.name = f"words-{len(self.vocabulary)}-{digest}"

    @classmethod
    def of(cls, texts: Iterable[str]) -> "WordTokenizer":
        """Return a tokenizer that knows every word of some texts, the sorted ones, and is as long as the longest."""
        split = [words(text) for text in texts]
        return cls(sorted(set().union(*split)), max(map(len, split), default=0) + 1)

    def encode(self, text: str) -> npt.NDArray[np.int32]:
        """Return (length,) int32."""
        return _padded(np.array([self._numbers.get(word, UNKNOWN) for word in words(text)], np.int32), self.length)


def _padded(numbers: npt.NDArray[np.int32], length: int) -> npt.NDArray[np.int32]:
    padded = np.full(length, PAD, np.int32)
    kept = numbers[: length - 1]
    padded[: len(kept)] = kept
    padded[len(kept)] = END
    return padded
