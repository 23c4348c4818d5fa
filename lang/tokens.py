r"""Text to tokens, right for scripts whose vowels are combining signs (never `\w`: it is not a letter to them)."""

import re
import unicodedata
from typing import NamedTuple

LATIN = "A-Za-z\u00c0-\u024f\u0300-\u036f"
"""Letters that may stand in a text of any language ("TV"), as a regular expression's character class."""


class Token(NamedTuple):
    """A word, a number or one mark.

    Attributes:
        text: normalised, in the case it was written in.
        start: of the token in the text as it was given.
        end: one past it.
    """

    text: str
    start: int
    end: int

    @property
    def key(self) -> str:
        """What it is compared by."""
        return self.text.casefold()


class Tokenizer:
    """Splits texts of one language.

    Args:
        letters: the script's letters and combining signs, as a regular expression's character class.
        digits: the script's own digits, likewise; 0 to 9 are always digits.
        ignored: characters that carry no meaning and are taken out, such as the zero-width joiner.
    """

    def __init__(self, letters: str, digits: str = "", ignored: str = "") -> None:
        inside = re.escape(ignored)
        self._token = re.compile(
            rf"[{LATIN}][{LATIN}{inside}]*(?:['’][{LATIN}]+)*|[{letters}][{letters}{inside}]*|[0-9{digits}]+|[^\s{inside}]"
        )
        self._letter = re.compile(f"[{letters}]")
        self._ignored = {ord(character): None for character in ignored}

    def normalise(self, text: str) -> str:
        """The text in Unicode's NFC, without what is ignored, each run of white space one space, none at the ends."""
        return " ".join(self._spelt(text).split())

    def split(self, text: str) -> list[Token]:
        """The text's tokens in order. Their places are those in `text` as given, normalised or not."""
        return [Token(self._spelt(m.group()), m.start(), m.end()) for m in self._token.finditer(text)]

    def count_letters(self, text: str) -> int:
        """How many characters of the text belong to the language's script."""
        return len(self._letter.findall(text))

    def _spelt(self, text: str) -> str:
        return unicodedata.normalize("NFC", text).translate(self._ignored)
