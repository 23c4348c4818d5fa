"""Words for collectibles in any text, for quality checks and missing objects; `noun_phrases.py` parses instructions."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Any

from arramon_lang.tokens import ScriptTokenizer, Token

FUZZY_LENGTH = 5
"""Minimum number of letters of a word that is recognised with one typing error."""

JOINTS = frozenset("-‐‑–")
"""Hyphens that may join the words of one phrase ("polka-dot"); they are ignored."""


class WordRole(Enum):
    """Role of a word in a noun phrase; the values are keys of `lexicon.toml`."""

    KIND = "kinds"
    PATTERNED_KIND = "patterned_kinds"  # a kind only with a stated pattern ("striped can"); otherwise street furniture
    PATTERN = "patterns"
    COLOUR = "colours"
    MODIFIER = "modifiers"  # possible in a noun phrase, without meaning in the catalogue
    STAND_IN = "stand_ins"  # replaces the kind ("the dotted one")
    OTHER = "others"  # a noun that is not a collectible: adjectives before it do not describe one
    HAVING = "having"  # introduces a description after the noun ("a ball with dots")


@dataclass(frozen=True, slots=True)
class LexiconEntry:
    """An entry of the lexicon, found in a text.

    Attributes:
        role: its role.
        value: the catalogue's name of the kind, pattern or colour; "" in other roles.
        length: number of tokens.
    """

    role: WordRole
    value: str
    length: int


_FUZZY_ROLES = (WordRole.KIND, WordRole.PATTERN, WordRole.COLOUR)
"""Roles whose words may have a typing error; others resemble common words too closely ("light", "right")."""


class Lexicon:
    """One language's words for collectibles, from its `lexicon.toml`.

    Args:
        data: the file's content.
        tokenizer: of the language.

    Raises:
        ValueError: if a table is missing, or a phrase is listed with two meanings.
    """

    def __init__(self, data: Mapping[str, Any], tokenizer: ScriptTokenizer) -> None:
        self._entries: dict[tuple[str, ...], tuple[WordRole, str]] = {}
        for role, value, phrase in _listed(data):
            key = keys_of(tokenizer.split(phrase))
            if self._entries.setdefault(key, (role, value)) != (role, value):
                raise ValueError(f"lexicon: {phrase!r} is listed as {value or role.value!r} and as something else")
        self._longest = max(map(len, self._entries))
        self._fuzzy = {
            key[0]: meaning
            for key, meaning in self._entries.items()
            if len(key) == 1 and len(key[0]) >= FUZZY_LENGTH and meaning[0] in _FUZZY_ROLES
        }
        self._never_fuzzy = frozenset(word.casefold() for word in data["not_misspelt"])

    def read(self, keys: Sequence[str], start: int) -> LexiconEntry | None:
        """Return the entry at `keys[start]`: the longest exact one, or else one word with a typing error."""
        for length in range(min(self._longest, len(keys) - start), 0, -1):
            meaning = self._entries.get(tuple(keys[start : start + length]))
            if meaning:
                return LexiconEntry(*meaning, length)
        return self._read_misspelt(keys[start])

    def _read_misspelt(self, key: str) -> LexiconEntry | None:
        if len(key) < FUZZY_LENGTH - 1 or key in self._never_fuzzy:
            return None
        meanings = {meaning for word, meaning in self._fuzzy.items() if within_one_edit(key, word)}
        return LexiconEntry(*meanings.pop(), 1) if len(meanings) == 1 else None


def keys_of(tokens: Iterable[Token]) -> tuple[str, ...]:
    """Return the comparison keys of tokens, without hyphens that join words."""
    return tuple(token.key for token in tokens if token.text not in JOINTS)


def within_one_edit(a: str, b: str) -> bool:
    """Return whether one insertion, deletion, substitution or transposition at most turns `a` into `b`."""
    if abs(len(a) - len(b)) > 1:
        return False
    if len(a) > len(b):
        a, b = b, a
    start = next((i for i, (x, y) in enumerate(zip(a, b, strict=False)) if x != y), len(a))
    if len(a) < len(b):
        return a[start:] == b[start + 1 :]
    swapped = a[start + 1 : start + 2] + a[start : start + 1] + a[start + 2 :]
    return a[start + 1 :] == b[start + 1 :] or swapped == b[start:]


def _listed(data: Mapping[str, Any]) -> Iterator[tuple[WordRole, str, str]]:
    for name in (*(role.value for role in WordRole), "not_misspelt"):
        if name not in data:
            raise ValueError(f"lexicon: {name!r} is missing")
    for role in WordRole:
        listed = data[role.value]
        tables: Mapping[str, Sequence[str]] = listed if isinstance(listed, Mapping) else {"": listed}
        for value, phrases in tables.items():
            for phrase in phrases:
                yield role, value, phrase
