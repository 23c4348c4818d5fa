"""Correction of a word's spelling: known variants of letters, and single typing errors in long words."""

from collections import Counter
from collections.abc import Callable, Collection, Iterable

from arramon_lang.lexicon import FUZZY_LENGTH, within_one_edit


class SpellingCorrector:
    """Corrects words towards a vocabulary.

    Args:
        vocabulary: known words.
        folding: (letters, replacement) pairs; spellings that agree after all replacements are one word.
        never_fuzzy: words that are not corrected.
        is_compound: whether a word consists of known parts, and is not corrected either.
    """

    def __init__(
        self,
        vocabulary: Collection[str],
        folding: Iterable[tuple[str, str]],
        never_fuzzy: Collection[str],
        is_compound: Callable[[str], bool],
    ) -> None:
        self._vocabulary, self._never_fuzzy, self._is_compound = vocabulary, never_fuzzy, is_compound
        self._folding = tuple(folding)
        self._long = [word for word in vocabulary if len(word) >= FUZZY_LENGTH]
        self._folded = self._spelt_alike()
        self._corrected: dict[str, str] = {}

    def correct(self, key: str) -> str:
        """Return the word, or the only known word with the same folded spelling or within one typing error."""
        if key in self._vocabulary or key in self._never_fuzzy:
            return key
        if self._is_compound(key):
            return key
        alike = self._folded.get(self._fold(key))
        if alike is not None:
            return alike
        if len(key) < FUZZY_LENGTH:
            return key
        if key not in self._corrected:
            near = [word for word in self._long if within_one_edit(key, word)]
            if len(near) > 1:  # The first letter is seldom wrong.
                near = [word for word in near if word[0] == key[0]]
            self._corrected[key] = near[0] if len(near) == 1 else key
        return self._corrected[key]

    def _fold(self, word: str) -> str:
        """Return a word with spelling variants folded together."""
        for one, other in self._folding:
            word = word.replace(one, other)
        return word

    def _spelt_alike(self) -> dict[str, str]:
        """Return the known word of each folded spelling that belongs to a single one."""
        found: dict[str, str] = {}
        if self._folding:
            folded = [(self._fold(word), word) for word in self._vocabulary]
            counts = Counter(spelling for spelling, _ in folded)
            found = {spelling: word for spelling, word in folded if counts[spelling] == 1}
        return found
