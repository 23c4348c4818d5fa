r"""Tokenizer for scripts with combining vowel signs, which `\w` does not match."""

import re
import unicodedata
from typing import NamedTuple

LATIN = "A-Za-z\u00c0-\u024f\u0300-\u036f"
"""Latin letters, allowed in texts of any language ("TV"), as a regular expression's character class."""


SENTENCE_ENDS = ".।॥۔。።"
"""Full stops of the world's scripts, of Unicode's property Sentence_Terminal; "?" and "!" are apart."""

PAUSES = ",;:،؛、，；："
"""Marks that divide a sentence, of Unicode's property Terminal_Punctuation."""


def strip_marks(word: str) -> str:
    """Return a word without punctuation and symbols (Unicode's categories P and S) at its ends."""
    first, last = 0, len(word)
    while first < last and unicodedata.category(word[first])[0] in "PS":
        first += 1
    while last > first and unicodedata.category(word[last - 1])[0] in "PS":
        last -= 1
    return word[first:last]


class Token(NamedTuple):
    """A word, a number or a punctuation mark.

    Attributes:
        text: normalised, with its original case.
        start: index of its first character in the text as given.
        end: index after its last character.
    """

    text: str
    start: int
    end: int

    @property
    def key(self) -> str:
        """The form used for comparisons."""
        return self.text.casefold()


class ScriptTokenizer:
    """Splits texts of one language into tokens.

    Args:
        letters: the script's letters and combining signs, as a regular expression's character class.
        digits: the script's own digits, as a character class; 0 to 9 are always digits.
        ignored: characters that carry no meaning and are removed, such as the zero-width joiner.
    """

    def __init__(self, letters: str, digits: str = "", ignored: str = "") -> None:
        inside = re.escape(ignored)
        self._token = re.compile(
            rf"[{LATIN}][{LATIN}{inside}]*(?:['’][{LATIN}]+)*|[{letters}][{letters}{inside}]*|[0-9{digits}]+|[^\s{inside}]"
        )
        self._letter = re.compile(f"[{letters}]")
        self._ignored = {ord(character): None for character in ignored}

    def normalise(self, text: str) -> str:
        """Return the text in Unicode's NFC, without ignored characters, with white space collapsed and stripped."""
        return " ".join(self._spelt(text).split())

    def split(self, text: str) -> list[Token]:
        """Return the text's tokens in order, with their positions in `text` as given."""
        return [Token(self._spelt(m.group()), m.start(), m.end()) for m in self._token.finditer(text)]

    def count_letters(self, text: str) -> int:
        """Return the number of characters of the text that belong to the language's script."""
        return len(self._letter.findall(text))

    def _spelt(self, text: str) -> str:
        return unicodedata.normalize("NFC", text).translate(self._ignored)
