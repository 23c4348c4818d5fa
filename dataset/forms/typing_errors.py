"""Typing errors: swapped, missing, doubled and neighbouring letters, lower case, no punctuation."""

import re
from random import Random

_ERRORS = 0.14
"""Share of words with an error."""

_MIN_LETTERS = 3
"""Minimum length of words with errors."""

_NEIGHBOURS = {
    "a": "qsz", "b": "vgn", "c": "xvd", "d": "sfe", "e": "wrd", "f": "dgr", "g": "fht", "h": "gjy", "i": "uok",
    "j": "hku", "k": "jli", "l": "ko", "m": "n", "n": "bm", "o": "ipl", "p": "ol", "q": "wa", "r": "etf", "s": "adw",
    "t": "ryg", "u": "yij", "v": "cb", "w": "qes", "x": "zc", "y": "tu", "z": "xa",
}  # fmt: skip
"""Keys beside each key."""

_KINDS = {"swap": 4, "drop": 4, "double": 1.5, "neighbour": 1.5, "space": 0.6}
"""Kinds of errors, by how often people make them."""


def with_typing_errors(text: str, random: Random) -> str:
    """Return an English text as someone types it in a hurry: in lower case, without punctuation, with errors."""
    words = re.sub(r"[.,;:!?]+(?=\s|$)", "", text).lower().split()
    typed = [_mistyped(word, random) if random.random() < _ERRORS else word for word in words]
    return " ".join(typed).replace("\b ", "").replace("\b", "")


def _mistyped(word: str, random: Random) -> str:
    if len(word) < _MIN_LETTERS or not word.isascii() or not word.isalpha():
        return word
    kind = random.choices(list(_KINDS), list(_KINDS.values()))[0]
    at = random.randrange(1, len(word))
    if kind == "swap":
        at = min(at, len(word) - 2) if len(word) > 3 or at < len(word) - 1 else 1
        return word[:at] + word[at + 1 : at + 2] + word[at] + word[at + 2 :]
    if kind == "drop":
        return word[:at] + word[at + 1 :]
    if kind == "double":
        return word[:at] + word[at] + word[at:]
    if kind == "neighbour":
        return word[:at] + random.choice(_NEIGHBOURS[word[at]]) + word[at + 1 :]
    return f"{word}\b"  # Joined to the next word: the marker and the space after it are removed.
