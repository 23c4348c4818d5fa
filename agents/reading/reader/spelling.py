"""Spelling of words for the learned reader: hashed character n-grams as in fastText, and typing errors for training."""

from collections.abc import Callable
from random import Random
from zlib import crc32

BUCKETS = 4096
"""Number of hash buckets of n-grams; ids are 1 to BUCKETS, and 0 is padding."""

NGRAM_SIZES = (1, 2, 3)
"""Lengths of n-grams, in characters. A word is enclosed in < and >, which alone are no n-grams."""

MAX_NGRAMS = 40
"""Maximum number of n-grams of a word: all those of 13 characters; longer words lose their last ones of length 3."""

MIN_LETTERS = 3
"""Minimum length of a word with a typing error: shorter ones would become other words."""


def hash_ngrams(word: str) -> list[int]:
    """Return the bucket ids of a word's n-grams, shortest first, padded with 0 to MAX_NGRAMS; "" has none."""
    enclosed = f"<{word}>"
    ngrams = [enclosed[first : first + size] for size in NGRAM_SIZES for first in range(len(enclosed) - size + 1)]
    ids = [crc32(ngram.encode()) % BUCKETS + 1 for ngram in ngrams if ngram.strip("<>")][:MAX_NGRAMS]
    return ids + [0] * (MAX_NGRAMS - len(ids))


def misspell(word: str, letters: str, random: Random) -> str:
    """Return a word with one typing error: two letters swapped, one left out, doubled or replaced by another.

    Args:
        word: returned as it is if it is shorter than MIN_LETTERS.
        letters: those that can replace another.
        random: source of all choices.
    """
    if len(word) < MIN_LETTERS:
        return word
    at = random.randrange(len(word) - 1)
    before, here, after, rest = word[:at], word[at], word[at + 1], word[at + 2 :]
    errors: tuple[Callable[[], str], ...] = (
        lambda: before + after + here + rest,
        lambda: before + after + rest,
        lambda: before + here + here + after + rest,
        lambda: before + here + random.choice(letters) + rest,
    )
    return random.choice(errors)()
