"""Sanitising of untrusted texts, such as a server's or a file's, before they are printed or stored."""

import json
import re
import unicodedata
from typing import Any

_UNSAFE = re.compile(
    "[\x00-\x1f\x7f-\x9f\xad\u061c\u180e\u200b\u200e\u200f\u2028-\u202e\u2060-\u206f\ufeff\ufff9-\ufffb\ud800-\udfff"
    "\U0001bca0-\U0001bca3\U0001d173-\U0001d17a\U000e0000-\U000e007f"
    "\u034f\u115f\u1160\u17b4\u17b5\u180b-\u180f\u2800\u3164\ufe00-\ufe0d\uffa0\U000e0100-\U000e01ef]"
)
"""Characters that move the cursor, change colours or the text direction, or are invisible, and lone surrogates.

The last line has fillers and variation selectors. The joiners U+200C and U+200D, which Devanagari needs, and the emoji
style selectors U+FE0E and U+FE0F are allowed."""

_UNSAFE_IN_LINES = re.compile("\r(?!\n)|" + _UNSAFE.pattern.replace("\x00-\x1f", "\x00-\x08\x0b\x0c\x0e-\x1f"))
"""Unsafe characters in a text of several lines, which may have tabs and newlines."""

_MAX_MARKS = 8
"""Maximum number of consecutive combining marks: no script needs as many, and a hundred cover the lines above."""

REPLACEMENT = "\ufffd"


def one_line(text: str, most: int = 500) -> str:
    """Return a text as one line that is safe to print.

    Args:
        text: any text.
        most: its maximum length in characters; a longer one is cut, and ends with an ellipsis.
    """
    if not (text.isascii() and text.isprintable()):
        text = _without_stacks(_UNSAFE.sub(REPLACEMENT, " ".join(re.split(r"[\t\n\r\u2028\u2029]+", text[: most + 1]))))
    return text if len(text) <= most else text[: most - 1] + "…"


def many_lines(text: str, most: int = 20_000) -> str:
    """Return a text that is safe to print, with its tabs and newlines; the arguments are as for `one_line`."""
    if not (text.isascii() and text.isprintable()):
        text = _without_stacks(_UNSAFE_IN_LINES.sub(REPLACEMENT, text[: most + 1]))
    return text if len(text) <= most else text[: most - 1] + "…"


def to_json(content: Any) -> str:
    """Return plain data as indented JSON with a final newline; unsafe characters are escaped."""
    text = json.dumps(content, indent=2, ensure_ascii=False)
    return _UNSAFE_IN_LINES.sub(_escape, text) + "\n"  # Unsafe characters occur only inside JSON strings.


def to_json_line(content: Any) -> str:
    """Return plain data as one line of JSON with a final newline; unsafe characters are escaped."""
    return _UNSAFE.sub(_escape, json.dumps(content, ensure_ascii=False)) + "\n"


def _escape(found: "re.Match[str]") -> str:
    return json.dumps(found.group())[1:-1]


def _without_stacks(text: str) -> str:
    kept, marks = [], 0
    for letter in text:
        category = unicodedata.category(letter)
        if category in ("Mn", "Me"):
            marks += 1
        elif category != "Cf":  # Marks after a joiner belong to the same letter.
            marks = 0
        if marks <= _MAX_MARKS:
            kept.append(letter)
    return "".join(kept) if len(kept) < len(text) else text
