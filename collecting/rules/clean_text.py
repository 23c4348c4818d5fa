"""Normalisation and limits of texts that workers send."""

import unicodedata

from arramon_server.errors import BadInput
from arramon_server.visible_text import invisible_part

DIRECTION = frozenset("\u061c\u200e\u200f\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069")
"""Marks that change the direction of the text."""

SYMBOLS = "°"
"""Symbols that are allowed, beside punctuation and those that the language's quality checks reject."""

NAMED_PHASES = ("navigation instruction", "assembly instruction")


def clean_instruction(text: str, most: int, name: str = "instruction") -> str:
    """Return an instruction in Unicode's form NFC, with single spaces and none around it.

    Args:
        text: as a browser sent it.
        most: maximum number of characters.
        name: what it is, for error messages.

    Raises:
        BadInput: if it is empty, too long, or has characters that are invisible, change the direction, or are emoji.
    """
    if len(text) > 4 * most:  # before anything is computed from it
        raise BadInput(f"the {name} has {len(text)} characters; at most {most} are allowed")
    try:
        text.encode()
    except UnicodeEncodeError:
        raise BadInput(f"the {name} has half a character; expected text") from None
    clean = " ".join(unicodedata.normalize("NFC", text).split())
    if not clean:
        raise BadInput(f"the {name} is empty")
    if len(clean) > most:
        raise BadInput(f"the {name} has {len(clean)} characters; at most {most} are allowed")
    for letter in clean:
        if letter in DIRECTION:
            raise BadInput(f"the {name} has a mark of text direction, U+{ord(letter):04X}; expected text without it")
        if unicodedata.category(letter) == "So" and letter not in SYMBOLS:
            raise BadInput(f"the {name} has the symbol {letter} (U+{ord(letter):04X}); expected words")
    if (odd := invisible_part(clean)) is not None:
        raise BadInput(f"the {name} has an invisible character, {odd}; expected visible text")
    return clean


def clean_instructions(texts: object, most: int) -> tuple[tuple[str, str], tuple[str, str]]:
    """Return the instructions of both turns, each checked by `clean_instruction`.

    Args:
        texts: `[[navigation, assembly], [navigation, assembly]]`, as a browser sent it.
        most: maximum number of characters of each.

    Raises:
        BadInput: if it is anything else, or a text is wrong.
    """
    pairs = list(texts) if isinstance(texts, list | tuple) else []
    if len(pairs) != 2 or not all(isinstance(pair, list | tuple) and len(pair) == 2 for pair in pairs):
        raise BadInput("the instructions are no two pairs, expected [[navigation, assembly], [navigation, assembly]]")
    if not all(isinstance(text, str) for pair in pairs for text in pair):
        raise BadInput("one of the instructions is no text")
    cleaned = [
        tuple(
            clean_instruction(text, most, f"{name} of turn {turn}")
            for text, name in zip(pair, NAMED_PHASES, strict=True)
        )
        for turn, pair in enumerate(pairs, start=1)
    ]
    (first_navigation, first_assembly), (second_navigation, second_assembly) = cleaned
    return (first_navigation, first_assembly), (second_navigation, second_assembly)
