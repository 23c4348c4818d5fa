"""Comparison of words by sound, between a language's own script and Latin letters as people type them."""

import re
from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from itertools import product
from typing import Any

VOWELS = "aeiou"

UNLIKE = 9.0
"""Distance of words that do not sound alike."""

_VOWEL_COSTS = {
    frozenset(pair): cost
    for pair, cost in {
        ("", "a"): 0.15, ("", "i"): 0.4, ("", "e"): 0.45, ("", "u"): 0.4, ("", "o"): 0.6, ("", "ai"): 0.6,
        ("a", "e"): 0.4, ("a", "i"): 0.6, ("a", "o"): 0.45, ("a", "u"): 0.45, ("a", "ai"): 0.3, ("a", "au"): 0.3,
        ("e", "i"): 0.25, ("e", "ai"): 0.2, ("i", "ai"): 0.4, ("e", "ei"): 0.05, ("i", "ei"): 0.2, ("ai", "ei"): 0.15,
        ("e", "ie"): 0.3, ("i", "ie"): 0.2, ("e", "ae"): 0.25, ("ai", "ae"): 0.1, ("a", "ae"): 0.4, ("ei", "ae"): 0.2,
        ("aei", "ae"): 0.05, ("aei", "ai"): 0.1, ("aie", "ae"): 0.2, ("aie", "ai"): 0.15, ("ai", "aii"): 0.05,
        ("o", "u"): 0.25, ("o", "au"): 0.15, ("o", "ou"): 0.1, ("au", "ou"): 0.1, ("u", "ou"): 0.2, ("o", "ao"): 0.35,
        ("au", "ao"): 0.1, ("aie", "aii"): 0.15, ("io", "o"): 0.5, ("ie", "iie"): 0.05, ("ii", "ie"): 0.2,
    }.items()
}  # fmt: skip
"""Costs of hearing one group of vowels as another. A short "a" is often left out; others are confused by length."""

_OTHER_VOWELS, _PER_LETTER = 0.3, 0.35
"""Cost of other pairs of vowel groups: a constant, and for each letter in which their lengths differ."""

_CONSONANT = 0.7
"""Cost of one consonant that is missing, added, wrong or swapped, in words with `_MIN_CONSONANTS` or more."""

_MIN_CONSONANTS = 3


class Sounds:
    """Sounds of words in a script, and of typed words in Latin letters.

    Args:
        data: content of a `latin.toml`: inherent, virama, nasals, consonants, vowels, heard and folding.
    """

    def __init__(self, data: Mapping[str, Any]) -> None:
        self._inherent, self._virama = data["inherent"], data["virama"]
        self._nasals = frozenset(data["nasals"])
        self._consonants: Mapping[str, str] = data["consonants"]
        self._vowels: Mapping[str, str] = data["vowels"]
        self._heard: Mapping[str, Sequence[str]] = data["heard"]
        self._folding = [(re.compile(rule["pattern"]), rule["sound"]) for rule in data["folding"]]

    def typed(self, word: str) -> str:
        """Return the folded sound of a word in Latin letters."""
        return _folded(word.casefold(), self._folding)

    def own(self, word: str) -> tuple[str, ...]:
        """Return the folded sounds of a word in the language's script: with and without its nasals, in all hearings."""
        parts = list(self._parts(word))
        return tuple(
            dict.fromkeys(_folded(_without_silent(each), self._folding) for each in product(*parts) if any(each))
        )

    def spelt(self, word: str) -> str:
        """Return a word of the language's script in Latin letters, in its first hearing and without its nasals."""
        return _without_silent([each[-1] if each == ("n", "") else each[0] for each in self._parts(word)])

    def _parts(self, word: str) -> Iterator[tuple[str, ...]]:
        """Yield the hearings of each letter; "@" marks an inherent vowel, which may be silent."""
        at = 0
        while at < len(word):
            letter = word[at : at + 2] if word[at : at + 2] in self._heard else word[at]
            at += len(letter)
            following = word[at : at + 1]
            if letter in self._heard or letter in self._consonants:
                while following and following not in self._vowels and not following.isalpha():
                    if following == self._virama or following in self._nasals:
                        break
                    at, following = at + 1, word[at + 1 : at + 2]  # A dot below.
                has_vowel = following in self._vowels and following not in _independent(self._vowels)
                end = "" if has_vowel or following == self._virama else "@"
                yield tuple(f"{sound}{end}" for sound in self._heard.get(letter, (self._consonants.get(letter, ""),)))
            elif letter in self._nasals:
                yield ("n", "")
            else:
                yield (self._vowels.get(letter, ""),)


def distance(typed: str, own: str) -> float:
    """Return how unlike two folded sounds are: 0 if they are equal, `UNLIKE` if one cannot be meant for the other."""
    if typed == own:
        return 0.0
    one, other = _split(typed), _split(own)
    if one[0] == other[0]:
        return _vowel_distance(one[1], other[1])
    if min(len(one[0]), len(other[0])) < _MIN_CONSONANTS or one[0][0] != other[0][0]:
        return UNLIKE
    return min((_CONSONANT + _vowel_distance(first, second) for first, second in _edited(one, other)), default=UNLIKE)


def _edited(
    one: tuple[str, tuple[str, ...]], other: tuple[str, tuple[str, ...]]
) -> Iterator[tuple[tuple[str, ...], tuple[str, ...]]]:
    """Yield the vowel groups that remain if the consonants differ in one place."""
    (consonants, vowels), (others, other_vowels) = one, other
    if len(consonants) == len(others):
        unlike = [n for n, (a, b) in enumerate(zip(consonants, others, strict=True)) if a != b]
        swapped = len(unlike) == 2 and consonants[unlike[0]] == others[unlike[1]] and unlike[1] == unlike[0] + 1
        if len(unlike) == 1 or (swapped and consonants[unlike[1]] == others[unlike[0]]):
            yield vowels, other_vowels
    elif len(consonants) + 1 == len(others):
        for n in range(1, len(others)):
            if others[:n] + others[n + 1 :] == consonants:
                joined = max(other_vowels[n : n + 2], key=len)
                yield vowels, (*other_vowels[:n], joined, *other_vowels[n + 2 :])
    elif len(consonants) == len(others) + 1:
        for first, second in _edited(other, one):
            yield second, first


@lru_cache(maxsize=1 << 16)
def _split(sound: str) -> tuple[str, tuple[str, ...]]:
    """Return a sound's consonants, and the groups of vowels before, between and after them."""
    consonants = re.sub(f"[{VOWELS}]", "", sound)
    return consonants, tuple(re.split(f"[^{VOWELS}]", sound))


def _vowel_distance(one: tuple[str, ...], other: tuple[str, ...]) -> float:
    return sum(_vowel_cost(first, second) for first, second in zip(one, other, strict=True) if first != second)


def _vowel_cost(one: str, other: str) -> float:
    known = _VOWEL_COSTS.get(frozenset((one, other)))
    return _OTHER_VOWELS + _PER_LETTER * (1 + abs(len(one) - len(other))) if known is None else known


def _folded(word: str, folding: Sequence[tuple[re.Pattern[str], str]]) -> str:
    for pattern, sound in folding:
        word = pattern.sub(sound, word)
    return word


def _without_silent(parts: Sequence[str]) -> str:
    """Return the joined parts; inherent vowels are silent at the end, and before a consonant between two vowels.

    From the end: a vowel that is heard keeps the one before it silent no more.
    """
    word = re.sub("@$", "", "".join(parts))
    for at in range(len(word) - 1, 0, -1):
        if word[at] == "@" and _BEFORE_SILENT.search(word[:at]) and _AFTER_SILENT.match(word[at + 1 :]):
            word = word[:at] + word[at + 1 :]
    return word.replace("@", "a")


_ONE_CONSONANT = f"(?:[kgcjtdpbs]h|[^{VOWELS}@])"

_BEFORE_SILENT = re.compile(f"[{VOWELS}@]{_ONE_CONSONANT}$")

_AFTER_SILENT = re.compile(f"{_ONE_CONSONANT}[{VOWELS}@]")


@lru_cache(maxsize=8)
def _independent_of(vowels: tuple[str, ...]) -> frozenset[str]:
    return frozenset(each for each in vowels if each.isalpha())


def _independent(vowels: Mapping[str, str]) -> frozenset[str]:
    return _independent_of(tuple(vowels))
