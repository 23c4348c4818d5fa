"""Notes that agents leave beside their actions."""

import json
from collections.abc import Mapping

from arramon_client.agent import Note
from arramon_client.errors import UsageError
from arramon_client.world import NOTE_BYTES


def note_text(note: Note | None) -> str:
    """Return a note as the text that is stored: a mapping becomes compact JSON; empty for None.

    Raises:
        UsageError: if it is neither text nor a mapping that JSON can hold, or if its text is not valid Unicode.
    """
    if note is None:
        return ""
    if isinstance(note, str):
        text = str(note)
    elif isinstance(note, Mapping):
        try:
            text = json.dumps(dict(note), ensure_ascii=False, separators=(",", ":"), allow_nan=False)
        except (TypeError, ValueError, RecursionError) as error:
            raise UsageError(f"the note cannot be written as JSON: {error}") from error
    else:
        raise UsageError(f"the note is of type {type(note).__name__}, expected text or a mapping")
    try:
        text.encode()
    except UnicodeEncodeError as error:
        raise UsageError(f"the note is not valid Unicode: {error.reason} at character {error.start}") from error
    return text


def note_fault(text: str) -> str:
    """Return why a note's text cannot be stored: it is too long; empty if it can."""
    size = len(text.encode())
    return "" if size <= NOTE_BYTES else f"a note has {size} bytes in UTF-8, expected at most {NOTE_BYTES}"
