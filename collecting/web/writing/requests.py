"""Requests of the write page: JSON objects, checked field by field."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from arramon_collecting.writing.characters import MAX_TEXT_CHARACTERS
from arramon_collecting.writing.walk import PARTS
from arramon_server.errors import BadInput, quoted

EVIDENCE = ("pastes", "pasted_characters", "insertions", "inserted_characters", "leaves", "away_seconds")
"""Counts that the page keeps of what may mean that a text was not typed: pasted, put in silently, the tab left."""

_MOST_COUNTED = 10_000_000
_ID = re.compile(r"[0-9a-f]{32}")


@dataclass(frozen=True, slots=True)
class Written:
    """What a page holds of a task.

    Attributes:
        editor: id of the window.
        position: text of the position.
        texts: as typed, one for each of `walk.PARTS`.
        evidence: the counts of EVIDENCE.
    """

    editor: str
    position: str
    texts: tuple[str, ...]
    evidence: Mapping[str, int]

    def as_body(self) -> dict[str, Any]:
        """Return it as the body of a draft."""
        return {
            "editor": self.editor,
            "position": self.position,
            "texts": list(self.texts),
            "evidence": dict(self.evidence),
        }

    @classmethod
    def of_body(cls, body: Mapping[str, Any], default: "Written") -> "Written":
        """Return what the body of a draft holds; the default if it is empty."""
        if not body:
            return default
        return cls(body["editor"], body["position"], tuple(body["texts"]), body["evidence"])


def read_editor(fields: Mapping[str, Any]) -> str:
    """Return the id of the window that asks to write.

    Raises:
        BadInput: if the request is malformed.
    """
    return _id(fields, "editor")


def read_draft(fields: Mapping[str, Any]) -> tuple[int, Written]:
    """Return the revision that a draft to save is based on, and its content.

    Raises:
        BadInput: if the request is malformed.
    """
    written = _written(fields)
    return _whole(fields, "revision"), written


def read_submission(fields: Mapping[str, Any]) -> tuple[str, Written]:
    """Return the id of a submission, and its content.

    Raises:
        BadInput: if the request is malformed.
    """
    written = _written(fields)
    return _id(fields, "submission"), written


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
    return Written(
        _id(fields, "editor"), position, tuple(texts), {name: _whole(evidence, name, 0) for name in EVIDENCE}
    )


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
