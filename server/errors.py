"""The error tree: all errors whose messages are meant for users.

ArraMonError
├── BadInput         arguments, files or settings are wrong
│   └── BadFile      a file is wrong; names file, line and field
├── NotFound         no such run, split, language or episode
├── Conflict         the request is not possible in the present state
│   ├── Replaced     a newer stream of the same player has taken the stream's place
│   └── TakenOver    another server process was faster; the request can be repeated
├── Unauthenticated  the token is missing or invalid
├── Forbidden        not allowed for this role or over this connection
├── OverQuota        a limit of the participant is reached; the message says when to try again
└── Unavailable      the server cannot serve the request now
    └── StorageError the journal or the data folder cannot be read or written
"""

from pathlib import Path

MAX_QUOTE_LENGTH = 100
"""Maximum number of characters of a caller's text that an error message quotes."""


def quoted(words: str) -> str:
    """Return a caller's text, quoted for an error message and truncated if it is long, as gRPC limits statuses."""
    if len(words) <= MAX_QUOTE_LENGTH:
        return repr(words)
    return f"{words[:MAX_QUOTE_LENGTH]!r}... ({len(words)} characters)"


class ArraMonError(Exception):
    """Base of all errors whose messages may be shown to users."""


class BadInput(ArraMonError):
    """An argument, file or setting is wrong; the message names it and what was expected."""


class BadFile(BadInput):
    """The content or the mode of a file is wrong.

    Args:
        path: path of the file.
        problem: what was wrong and what was expected.
        line: 1-based line number; None if unknown.
        field: dotted name of the field, such as `gt_paths.navi_path_gt[1]`; None if unknown.
    """

    def __init__(self, path: Path | str, problem: str, *, line: int | None = None, field: str | None = None) -> None:
        place = str(path) + (f":{line}" if line is not None else "") + (f": {field}" if field else "")
        super().__init__(f"{place}: {problem}")
        self.path, self.line, self.field, self.problem = Path(path), line, field, problem


class NotFound(ArraMonError):
    """The requested object does not exist; the message names those that do, where possible."""


class Conflict(ArraMonError):
    """The request is not possible in the present state, such as the scores of a run that is still being played."""


class Replaced(Conflict):
    """A newer stream of the same player plays the run now."""


class TakenOver(Conflict):
    """Another process of this server was faster. The caller can try again, and sees the new state."""


class Unauthenticated(ArraMonError):
    """The token is missing where one is required, or is invalid; the message says what to do."""


class Forbidden(ArraMonError):
    """The caller is not allowed to make the request, whether or not it is authenticated."""


class OverQuota(ArraMonError):
    """A limit of the participant is reached; the message names it, the usage, and when the next request is possible."""


class Unavailable(ArraMonError):
    """The server cannot serve the request now, for instance while it shuts down. No confirmed step is lost."""


class StorageError(Unavailable):
    """The journal or the data folder cannot be read or written. No confirmed step is lost."""
