"""Tokenizers: instructions as padded arrays of token ids, for learners that do not accept texts."""

import hashlib
from collections.abc import Iterable, Sequence
from typing import Protocol

import numpy as np
import numpy.typing as npt

from arramon_client.words import words

PAD, END, UNKNOWN, SPECIAL = 0, 1, 2, 3
"""Token ids of padding, the end of a text and unknown words; number of special ids."""


class Tokenizer(Protocol):
    """Converts texts to token ids.

    Attributes:
        name: unique name of the tokenizer and its vocabulary.
        size: size of the vocabulary; all token ids are below it.
        length: length of every encoded text, including padding.
    """

    name: str
    size: int
    length: int

    def encode(self, text: str) -> npt.NDArray[np.int32]:
        """Return a new array of token ids, (length,) int32; a longer text is truncated."""


class ByteTokenizer:
    """Tokenizer of UTF-8 bytes, numbered as in ByT5: byte + 3, then 1 for the end, then 0. It needs no vocabulary.

    Args:
        longest: length of the longest text in bytes.
    """

    name = "utf8-bytes"
    size = 256 + SPECIAL

    def __init__(self, longest: int) -> None:
        self.length = longest + 1

    def encode(self, text: str) -> npt.NDArray[np.int32]:
        """Return the token ids, (length,) int32."""
        numbers = np.frombuffer(text.encode(), np.uint8).astype(np.int32) + SPECIAL
        return _padded(numbers, self.length)


class WordTokenizer:
    """Tokenizer of words, numbered in the order of a vocabulary; punctuation marks count as words.

    A word is a run of letters with their combining marks and digits, in lower case. Use the same tokenizer for all
    splits: build it from the training texts with `WordTokenizer.of`.

    Args:
        vocabulary: the known words.
        length: maximum number of words of a text, plus 1 for its end; longer texts are truncated.
    """

    def __init__(self, vocabulary: Sequence[str], length: int) -> None:
        self.vocabulary, self.length = tuple(vocabulary), length
        self._numbers = {word: number for number, word in enumerate(self.vocabulary, start=SPECIAL)}
        self.size = len(self.vocabulary) + SPECIAL
        digest = hashlib.sha256("\n".join(self.vocabulary).encode()).hexdigest()[:8]
        self.name = f"words-{len(self.vocabulary)}-{digest}"

    @classmethod
    def of(cls, texts: Iterable[str]) -> "WordTokenizer":
        """Return a tokenizer with all words of the given texts, sorted, and the length of the longest text."""
        split = [words(text) for text in texts]
        return cls(sorted(set().union(*split)), max(map(len, split), default=0) + 1)

    def encode(self, text: str) -> npt.NDArray[np.int32]:
        """Return the token ids, (length,) int32."""
        return _padded(np.array([self._numbers.get(word, UNKNOWN) for word in words(text)], np.int32), self.length)


def _padded(numbers: npt.NDArray[np.int32], length: int) -> npt.NDArray[np.int32]:
    padded = np.full(length, PAD, np.int32)
    kept = numbers[: length - 1]
    padded[: len(kept)] = kept
    padded[len(kept)] = END
    return padded
