"""Validation of texts that participants show to others: visible characters without side effects, mostly one line.

Joiners (U+200C, U+200D) are allowed after a character, as Devanagari and emoji need them, and so are emoji style
selectors (U+FE0E, U+FE0F); on their own they would be invisible.
"""

import re
import unicodedata

JOINERS = "\u200c\u200d"
"""Zero-width non-joiner and joiner."""

STYLES = "\ufe0e\ufe0f"
"""Variation selectors that choose between text and colour forms of an emoji."""

MAX_MARKS = 4
"""Maximum number of combining marks in a row. No language needs more, and taller stacks would cover other lines."""

_BLANK = re.compile("[\u034f\u115f\u1160\u17b4\u17b5\u180b-\u180f\u2800\u3164\ufe00-\ufe0d\uffa0\U000e0100-\U000e01ef]")
"""Invisible characters that Python considers printable: fillers and variation selectors."""

_LONE = re.compile(rf"(?:^|[\s{JOINERS}])[{JOINERS}]|(?:^|[\s{JOINERS}{STYLES}])[{STYLES}]")
"""A joiner or selector that does not follow a character."""


def is_visible(text: str) -> bool:
    """Return whether a text is one line of visible characters, without control of cursor or text direction."""
    return invisible_part(text) is None


def invisible_part(text: str) -> str | None:
    """Return the part of a text that is not allowed in visible text, such as "U+200B (ZERO WIDTH SPACE)"; or None."""
    for letter in text:
        if letter not in JOINERS and (not letter.isprintable() or _BLANK.match(letter)):
            return _named(letter)
    if (lone := _LONE.search(text)) is not None:
        return _named(lone[0][-1]) + " alone"
    row, before = 0, " "
    for letter in text:
        is_mark = _is_mark(letter)
        row = row + 1 if is_mark else row if letter in JOINERS else 0
        if is_mark and (before.isspace() or row > MAX_MARKS):
            return _named(letter) + (" after no letter" if before.isspace() else f" after {MAX_MARKS} other marks")
        before = letter
    return None


def shown(text: str) -> str:
    """Return a text for display, with what `is_visible` rejects replaced: old and imported texts may have it."""
    kept, row = list[str](), 0
    for letter in text:
        row = row + 1 if _is_mark(letter) else row if letter in JOINERS else 0
        is_odd = letter not in JOINERS and (not letter.isprintable() or _BLANK.match(letter))
        if row <= MAX_MARKS:
            kept.append("\ufffd" if is_odd and letter not in _SPACES else letter)
    return "".join(kept)


def shown_lines(text: str) -> str:
    """Return a text of several lines with what `is_visible` rejects replaced, but for its tabs and ends of lines.

    All ends of lines become "\\n".
    """
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    if text.isascii() and text.replace("\n", "").replace("\t", "").isprintable():
        return text
    return "\n".join("\t".join(map(shown, line.split("\t"))) for line in text.split("\n"))


def _is_mark(letter: str) -> bool:
    return letter not in STYLES and unicodedata.category(letter) in ("Mn", "Me")


def _named(letter: str) -> str:
    name = unicodedata.name(letter, "a control character" if unicodedata.category(letter) == "Cc" else "")
    return f"U+{ord(letter):04X}" + (f" ({name})" if name else "")


_SPACES = frozenset("\u00a0\u2007\u202f")
"""Spaces that keep words together, which Python does not consider printable."""
