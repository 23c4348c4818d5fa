"""Splitting of a text in any script into words."""

import unicodedata
from itertools import groupby

_WORD_CATEGORIES = frozenset(("Lu", "Ll", "Lt", "Lm", "Lo", "Mn", "Mc", "Me", "Nd", "Cf"))


def words(text: str) -> list[str]:
    """Return the words and punctuation marks of a text in any script, in lower case (NFC)."""
    found = []
    for kind, run in groupby(unicodedata.normalize("NFC", text).casefold(), _kind):
        if kind == "word":
            found.append("".join(run))
        elif kind == "mark":
            found.extend(run)
    return found


def _kind(character: str) -> str:
    if character.isspace():
        return "space"
    # Letters, combining marks (such as Devanagari's vowel signs), digits, and zero-width joiners.
    return "word" if unicodedata.category(character) in _WORD_CATEGORIES else "mark"
