"""Preferences among drafts of a text: how much likelier people are than the grammar to write certain word sequences."""

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

LONGEST = 3
"""Maximum number of words of a sequence."""

OTHER = "_"
"""Stands for one or more words that no sequence contains, such as names of things."""

_WORDS = re.compile(r"\w+(?:['’-]\w+)*|[^\w\s]")


class Preferences:
    """Log-odds of word sequences, from `preferences.toml`.

    Args:
        data: by phase, the weight of each sequence. Sequences are of words in small letters and punctuation marks; "<"
            and ">" are a text's beginning and end, "_" stands for other words.
    """

    def __init__(self, data: Mapping[str, Any]) -> None:
        self._weights: dict[str, dict[str, float]] = {phase: dict(data[phase]) for phase in data}
        self._words = {phase: {word for key in each for word in key.split()} for phase, each in self._weights.items()}

    def score(self, text: str, phase: str) -> float:
        """Return the sum of the weights of all sequences that a text contains, each counted once."""
        weights = self._weights.get(phase, {})
        if not weights:
            return 0.0
        return sum(weights.get(each, 0.0) for each in set(sequences(reduced(text, self._words[phase]))))


def reduced(text: str, kept: set[str]) -> list[str]:
    """Return a text's words in small letters, with "_" for each run of words that are not kept."""
    words = ["<", *(word if word in kept else OTHER for word in _WORDS.findall(text.casefold())), ">"]
    return [word for place, word in enumerate(words) if word != OTHER or words[place - 1] != OTHER]


def sequences(words: Sequence[str]) -> Iterator[str]:
    """Yield all sequences of up to LONGEST words."""
    for start in range(len(words)):
        for size in range(1, min(LONGEST, len(words) - start) + 1):
            yield " ".join(words[start : start + size])
