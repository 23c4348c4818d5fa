"""Hindi texts with English words, in Latin letters (Hinglish) or in Devanagari."""

import re
from dataclasses import dataclass
from random import Random

from arramon_dataset.forms.romaniser import Romaniser
from arramon_dataset.forms.tables import replacements

NOUNS, VERBS = 1, 2
"""Densities: English nouns and adjectives; verbs and directions as well."""

_KEPT = 0.15
"""Share of words that stay Hindi although there is an English one."""


def hinglish(text: str, density: int, random: Random) -> str:
    """Return a Hindi text in Latin letters, with English words.

    Args:
        text: in Devanagari.
        density: NOUNS or VERBS.
        random: source of all choices.
    """
    return Romaniser(random).text(_with_english(text, density, random, in_latin=True))


def with_loans(text: str, random: Random) -> str:
    """Return a Hindi text in Devanagari with English nouns, adjectives, verbs and directions."""
    return _with_english(text, VERBS, random, in_latin=False)


def _with_english(text: str, density: int, random: Random, *, in_latin: bool) -> str:
    for kind in ("acts", "things")[0 if density == VERBS else 1 :]:
        for replacement in replacements(kind):
            wordings = replacement.english if in_latin else replacement.loan
            # One word a thing in one text, as people write; acts vary.
            usual = random.choice(wordings) if kind == "things" else ""
            text = replacement.hindi.sub(_Choice(wordings, usual, random), text)
    return text


@dataclass(frozen=True, slots=True)
class _Choice:
    """Choice of what stands for a Hindi word: the usual wording if there is one, any, or the word itself."""

    wordings: tuple[str, ...]
    usual: str
    random: Random

    def __call__(self, match: re.Match[str]) -> str:
        if self.random.random() < _KEPT:
            return match.group()
        return self.usual or self.random.choice(self.wordings)
