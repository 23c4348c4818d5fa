"""Correction of typing errors, bounded to a language's own vocabulary: no word is better than a wrong one."""

import itertools
from collections import defaultdict
from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any

_COSTS = {"swap": 0.6, "double": 0.5, "missing": 0.8, "extra": 0.9, "neighbour": 0.8, "vowel": 0.9, "other": 1.3}
"""Costs of one error: letters swapped, a letter once for twice or twice for once, missing, added, or wrong."""

_FIRST = 0.7
"""Extra cost of an error in the first letter, which is seldom wrong."""

_RARE = 0.4
"""Extra cost of words that are not among the common ones."""

_MAX_COST, _MAX_COST_OF_TWO = 1.4, 1.7
"""Maximum cost of a correction with one error, and with two."""

_MARGIN = 0.2
"""How much better the best correction must be than the second, but for one that only has another ending."""

_FREQUENT, _FREQUENT_WORDS = 0.2, 60
"""Discount of the most frequent words, and their number."""

_NAMING = 0.35
"""Discount of nouns and adjectives beside others: "the bule ball"."""

_ENDING = 3
"""Maximum number of letters by which two forms of a word differ at the end."""

_SHORTEST, _SHORTEST_RARE, _SHORTEST_WITH_TWO = 3, 4, 7
"""Letters that a word must have to be corrected; to one that is not common; and for two errors. Two letters are
corrected to three alone."""

_PARTS = 3
"""Maximum number of words that were typed without a space."""

_VOWELS = frozenset("aeiou")


class TypingCorrector:
    """Corrector of one language.

    Args:
        vocabulary: words that the language's texts are read by.
        naming: those of them that noun phrases consist of.
        data: content of a `typing.toml`: common, known, short and keyboard.
    """

    def __init__(self, vocabulary: Collection[str], naming: Collection[str], data: Mapping[str, Any]) -> None:
        self._vocabulary = frozenset(vocabulary)
        self._known = self._vocabulary | frozenset(data["known"])
        self._common = frozenset(data["common"]) & self._vocabulary
        self._frequent = frozenset(data["common"][:_FREQUENT_WORDS])
        self._naming = frozenset(naming)
        self._short: Mapping[str, str] = data["short"]
        self._beside = _keys_beside(data["keyboard"])
        self._by_length: dict[int, list[str]] = defaultdict(list)
        for word in sorted(self._vocabulary):
            if word.isalpha():
                self._by_length[len(word)].append(word)
        self._ranked: dict[str, list[tuple[float, str]]] = {}

    def correct(self, keys: Sequence[str]) -> tuple[str, ...]:
        """Return a text's words with errors corrected; a word may become several, or two change where they divide."""
        corrected: list[str] = []
        at = 0
        while at < len(keys):
            moved = self._with_space_moved(keys[at : at + 2])
            before, after = corrected[-1] if corrected else "", keys[at + 1] if at + 1 < len(keys) else ""
            corrected += moved or self.words(keys[at], before, after)
            at += 2 if moved else 1
        return tuple(corrected)

    def words(self, key: str, before: str = "", after: str = "") -> tuple[str, ...]:
        """Return the words that one stands for: itself if it is known, or if nothing is likely.

        Args:
            key: the word.
            before, after: its neighbours.
        """
        if key in self._short:
            return tuple(self._short[key].split())
        if not self._is_unknown(key):
            return (key,)
        if key not in self._ranked:
            self._ranked[key] = sorted(self._candidates(key))
        beside = before in self._naming or after in self._naming
        ranked = sorted(
            (cost - _NAMING * (beside > 0 and word in self._naming), word) for cost, word in self._ranked[key]
        )
        is_clear = bool(ranked) and all(
            cost - ranked[0][0] >= _MARGIN or _differ_in_ending(word, ranked[0][1]) for cost, word in ranked[1:]
        )
        divided = self._divided(key, _PARTS)
        if divided and not (is_clear and ranked[0][0] <= _COSTS["swap"]):
            return divided
        return (ranked[0][1],) if is_clear else (key,)

    def _is_unknown(self, key: str) -> bool:
        return self._is_odd(key) and len(key) >= _SHORTEST - 1

    def _candidates(self, key: str) -> Iterator[tuple[float, str]]:
        for length in range(len(key) - 1, len(key) + 2):
            for word in self._by_length.get(length, ()):
                is_common = word in self._common
                if (not is_common and len(key) < _SHORTEST_RARE) or (len(key) < _SHORTEST and len(word) != _SHORTEST):
                    continue
                cost = self._cost(key, word)
                if cost is not None:
                    yield cost + (-_FREQUENT if word in self._frequent else 0.0 if is_common else _RARE), word

    def _cost(self, key: str, word: str) -> float | None:
        """Return the cost of typing `key` for `word`, with one error, or two in a long word; None if it takes more."""
        one = self._of_one_error(key, word)
        if one is not None:
            return one if one <= _MAX_COST else None
        if min(len(key), len(word)) < _SHORTEST_WITH_TWO or key[0] != word[0]:
            return None
        found = (
            (first + second)
            for between, first in self._after_one_repair(key, word)
            if (second := self._of_one_error(between, word)) is not None
        )
        cost = min(found, default=_MAX_COST_OF_TWO + 1.0)
        return cost if cost <= _MAX_COST_OF_TWO else None

    def _after_one_repair(self, key: str, word: str) -> Iterator[tuple[str, float]]:
        """Yield what becomes of a word if its first difference from another is repaired in each way."""
        at = next((n for n, (a, b) in enumerate(zip(key, word, strict=False)) if a != b), min(len(key), len(word)))
        for repaired in (
            key[:at] + word[at : at + 1] + key[at + 1 :],
            key[:at] + word[at : at + 1] + key[at:],
            key[:at] + key[at + 1 :],
            key[:at] + key[at + 1 : at + 2] + key[at : at + 1] + key[at + 2 :],
        ):
            cost = self._of_one_error(key, repaired)
            if cost is not None and repaired != key:
                yield repaired, cost

    def _of_one_error(self, key: str, word: str) -> float | None:
        """Return the cost of the one error in which two words differ; None if they differ in more."""
        if key == word:
            return 0.0
        at = next((n for n, (a, b) in enumerate(zip(key, word, strict=False)) if a != b), min(len(key), len(word)))
        first = _FIRST if at == 0 else 0.0
        if len(key) == len(word):
            if key[at + 1 :] == word[at + 1 :]:
                return first + self._of_wrong_letter(key[at], word[at])
            is_swapped = key[at : at + 2] == word[at : at + 2][::-1] and key[at + 2 :] == word[at + 2 :]
            return first + _COSTS["swap"] if is_swapped else None
        longer, shorter = (key, word) if len(key) > len(word) else (word, key)
        if longer[at + 1 :] != shorter[at:]:
            return None
        if at and longer[at] == longer[at - 1]:
            return _COSTS["double"]
        return first + _COSTS["extra" if longer is key else "missing"]

    def _of_wrong_letter(self, typed: str, meant: str) -> float:
        if (typed, meant) in self._beside:
            return _COSTS["neighbour"]
        return _COSTS["vowel" if typed in _VOWELS and meant in _VOWELS else "other"]

    def _divided(self, key: str, parts: int) -> tuple[str, ...]:
        """Return the words that were typed as one, or none."""
        for at in range(len(key) - 1, 0, -1):
            head, rest = key[:at], key[at:]
            if head in self._common and (len(head) > 1 or head == "a"):
                if rest in self._common and (len(rest) > 1 or rest == "a") and (len(head) > 2 or len(rest) > 2):
                    return head, rest
                further = self._divided(rest, parts - 1) if parts > 2 and len(head) > 2 else ()
                if further:
                    return head, *further
        return ()

    def _with_space_moved(self, keys: Sequence[str]) -> tuple[str, ...]:
        """Return two words whose space was typed one letter too early or too late, or none."""
        if len(keys) < 2 or not (self._is_odd(keys[0]) and self._is_odd(keys[1])):
            return ()
        for one, other in (
            (keys[0] + keys[1][0], keys[1][1:]),
            (keys[0][:-1], keys[0][-1] + keys[1]),
        ):
            if one in self._common and other in self._common:
                return one, other
        return ()

    def _is_odd(self, key: str) -> bool:
        return key.isalpha() and key.isascii() and key not in self._known


def _differ_in_ending(one: str, other: str) -> bool:
    """Return whether two words are forms of one, such as "toward" and "towards"."""
    shorter, longer = sorted((one, other), key=len)
    return len(shorter) > _ENDING and longer.startswith(shorter) and len(longer) - len(shorter) <= _ENDING


def _keys_beside(rows: Sequence[str]) -> frozenset[tuple[str, str]]:
    """Return the pairs of letters whose keys touch; each row stands half a key further right than the one above."""
    pairs: set[tuple[str, str]] = set()
    for number, row in enumerate(rows):
        pairs.update(itertools.pairwise(row))
        for at, key in enumerate(row):
            below = rows[number + 1] if number + 1 < len(rows) else ""
            pairs.update((key, other) for other in below[max(at - 1, 0) : at + 1])
    return frozenset((*pairs, *((b, a) for a, b in pairs)))
