"""Reading of untrusted JSON, which raises one kind of error for any invalid text."""

import json
import math
from collections.abc import Iterable
from typing import Any, NoReturn

DEEPEST = 64
"""Default maximum nesting depth of lists and objects; this project's own files have fewer than ten levels."""


class NotJsonError(ValueError):
    """A text is not JSON, or is JSON that this project does not accept; the message is a predicate: "is not JSON"."""


def read_json(data: bytes | str, deepest: int = DEEPEST) -> Any:
    """Return the content of a JSON text.

    Args:
        data: the text; bytes may be UTF-8 (with or without a byte order mark), UTF-16 or UTF-32.
        deepest: maximum nesting depth of lists and objects.

    Raises:
        NotJsonError: if it is not JSON, is nested more deeply, or has a number that JSON does not have (NaN, Infinity)
            or that a float cannot hold (1e999).
    """
    try:
        content = json.loads(data, parse_constant=_refuse)
    except RecursionError:
        raise NotJsonError(f"is nested more than {deepest} levels deep") from None
    except NotJsonError:
        raise
    except ValueError as error:  # also bytes that are no text, and numbers of thousands of digits
        raise NotJsonError("is not JSON, or was truncated") from error
    _check(content, deepest)
    return content


def _check(content: Any, deepest: int) -> None:
    level, depth = [content], 0
    while level:
        inner: list[Any] = []
        for value in level:
            if isinstance(value, dict | list):
                inner.extend(_contained(value))
                if depth == deepest:
                    raise NotJsonError(f"is nested more than {deepest} levels deep")
            elif isinstance(value, float) and not math.isfinite(value):
                raise NotJsonError("has a number that is too large")
        level, depth = inner, depth + 1


def _contained(value: Any) -> Iterable[Any]:
    return value.values() if isinstance(value, dict) else value


def _refuse(text: str) -> NoReturn:
    raise NotJsonError(f"has the number {text}, which JSON does not have")
