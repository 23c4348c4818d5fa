"""Requests of the write page: JSON objects, checked field by field."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from arramon.strict_json import NotJsonError, read_json
from arramon_collecting.writing.characters import MAX_TEXT_CHARACTERS
from arramon_collecting.writing.walk import PARTS
from arramon_server.errors import BadInput, quoted

MAX_REQUEST_BYTES = 512 << 10
"""Size limit of a request: four texts of the longest kind, with every character of four bytes."""

EVIDENCE = (
    "pastes", "pasted_characters", "insertions", "inserted_characters", "leaves", "away_seconds", "active_seconds",
)  # fmt: skip
"""Counts that the page keeps of what may mean that a text was not typed, and of the time that was spent on it."""

_MOST_COUNTED = 10_000_000
_ID = re.compile(r"[0-9a-f]{32}")


@dataclass(frozen=True, slots=True)
class Written:
    """What a page holds of a task.

    Attributes:
        position: text of the position.
        texts: as typed, one for each of `walk.PARTS`.
        evidence: the counts of EVIDENCE.
    """

    position: str
    texts: tuple[str, ...]
    evidence: Mapping[str, int]

    def as_body(self, editor: str) -> dict[str, Any]:
        """Return it as the body of a draft of a window."""
        return {
            "editor": editor,
            "position": self.position,
            "texts": list(self.texts),
            "evidence": dict(self.evidence),
        }

    @classmethod
    def of_body(cls, body: Mapping[str, Any], position: str) -> "Written":
        """Return what the body of a draft holds; for an empty one no texts, at a position."""
        return cls(
            body.get("position", position),
            tuple(body.get("texts", ("",) * len(PARTS))),
            {name: body.get("evidence", {}).get(name, 0) for name in EVIDENCE},
        )


@dataclass(frozen=True, slots=True)
class DraftRequest:
    """A draft to save.

    Attributes:
        revision: the revision that it is based on.
        editor: id of the window.
        written: its content.
    """

    revision: int
    editor: str
    written: Written


def read_editor(body: bytes) -> str:
    """Return the id of the window that asks to write.

    Raises:
        BadInput: if the request is malformed.
    """
    return _id(_fields(body), "editor")


def read_draft(body: bytes) -> DraftRequest:
    """Parse a request to save a draft.

    Raises:
        BadInput: if it is malformed.
    """
    fields = _fields(body)
    return DraftRequest(_whole(fields, "revision"), _id(fields, "editor"), _written(fields))


def read_submission(body: bytes) -> tuple[str, Written]:
    """Parse a submission; return its id and its content.

    Raises:
        BadInput: if it is malformed.
    """
    fields = _fields(body)
    return _id(fields, "submission"), _written(fields)


def _written(fields: Mapping[str, Any]) -> Written:
    texts = fields.get("texts")
    if not isinstance(texts, list) or len(texts) != len(PARTS) or not all(isinstance(text, str) for text in texts):
        raise BadInput(f"texts is no list of {len(PARTS)} texts")
    for text in texts:
        if len(text) > MAX_TEXT_CHARACTERS:
            raise BadInput(f"a text has {len(text)} characters; at most {MAX_TEXT_CHARACTERS} can be kept")
        try:
            text.encode()
        except UnicodeEncodeError:
            raise BadInput("a text has half of a character") from None
    position, evidence = fields.get("position"), fields.get("evidence", {})
    if not isinstance(position, str) or len(position) > 40:
        raise BadInput("position is no text of a position")
    if not isinstance(evidence, dict):
        raise BadInput("evidence is no object of counts")
    return Written(position, tuple(texts), {name: _whole(evidence, name, 0) for name in EVIDENCE})


def _fields(body: bytes) -> dict[str, Any]:
    try:
        content = read_json(body.decode(), deepest=4)
    except (NotJsonError, UnicodeDecodeError) as error:
        raise BadInput(f"the request is no JSON: {error}") from error
    if not isinstance(content, dict):
        raise BadInput("the request is no JSON object")
    return content


def _id(fields: Mapping[str, Any], name: str) -> str:
    value = fields.get(name)
    if not isinstance(value, str) or not _ID.fullmatch(value):
        raise BadInput(f"{name} is {quoted(str(value))}, expected 32 hexadecimal digits")
    return value


def _whole(fields: Mapping[str, Any], name: str, default: int | None = None) -> int:
    value = fields.get(name, default)
    if type(value) is not int or not 0 <= value <= _MOST_COUNTED:
        raise BadInput(f"{name} is {quoted(str(value))}, expected a whole number from 0 to {_MOST_COUNTED}")
    return value
