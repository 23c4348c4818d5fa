"""Characters of a writer's text: its stored form, and characters that no instruction may have."""

import unicodedata
from collections.abc import Iterator
from pathlib import Path

from arramon_lang.language import ROOT, Language, load
from arramon_server.visible_text import JOINERS, invisible_part

MAX_TEXT_CHARACTERS = 10_000
"""Length of a text beyond which a draft is refused; up to here it is kept, however long a collection's texts may be."""

_SELECTORS = "\ufe0e\ufe0f"
_PICTURES = range(0x1F000, 0x20000)


def stored_form(text: str, language: str) -> str:
    """Return a text as it is stored: in Unicode's NFC, with single spaces, without joiners that carry no meaning."""
    spelt = load(language)
    for joiner in JOINERS:
        probe = f"a{joiner}a"
        if spelt.normalise(probe) == "aa" and spelt.without_spelt_joiners(probe) == probe:
            text = text.replace(joiner, "")
    return " ".join(unicodedata.normalize("NFC", text).split())


def pictures_in(text: str) -> tuple[str, ...]:
    """Return the emoji and pictographs in a text, each once, in order."""
    return tuple(dict.fromkeys(filter(_is_picture, text)))


def invisible_in(text: str, language: str, root: Path = ROOT) -> tuple[str, ...]:
    """Return the invisible characters in a text that must not be in it, each once, in order.

    These are controls, marks of writing direction, and spaces of no width. Joiners may stand where the language's
    spelling has them.
    """
    return tuple(dict.fromkeys(_invisible(text, load(language, root))))


def _invisible(text: str, language: Language) -> Iterator[str]:
    meaningless = {joiner for joiner in JOINERS if language.normalise(f"a{joiner}a") != "aa"}
    before = ""
    for letter in text:
        is_odd = letter in meaningless if letter in JOINERS else invisible_part(letter) is not None
        is_lone = letter in JOINERS and not before.strip(JOINERS + " ")
        if not letter.isspace() and letter not in _SELECTORS and not _is_mark(letter) and (is_odd or is_lone):
            yield letter
        before = letter


def _is_mark(letter: str) -> bool:
    return unicodedata.category(letter) in ("Mn", "Mc", "Me")


def _is_picture(letter: str) -> bool:
    is_symbol = unicodedata.category(letter) == "So" and letter != "°"
    return is_symbol or ord(letter) in _PICTURES or letter in _SELECTORS
