"""The error tree: everything that the server can say is wrong, in words for whoever caused it.

ArraMonError
├── BadInput        the caller's words, files or settings are wrong
│   └── BadFile     a file is wrong; names file, line and field
├── NotFound        no such run, split, language or episode
├── Conflict        the request is right, but not in this state
├── Unauthenticated no token, or one that is not good
├── Forbidden       not with this role, or not over this connection
├── OverQuota       a limit of the participant's is reached; names it, and when the next is possible
└── StorageError    the journal or the data folder cannot be read or written
"""

from pathlib import Path


class ArraMonError(Exception):
    """Base of all errors whose message may be shown to a user as it is."""


class BadInput(ArraMonError):
    """Something given by the caller is wrong; the message names it and what was expected."""


class BadFile(BadInput):
    """A file's content is wrong.

    Args:
        path: the file.
        problem: what was wrong and what was expected.
        line: 1-based line, where one is known.
        field: dotted name of the field, such as `gt_paths.navi_path_gt[1]`.
    """

    def __init__(self, path: Path | str, problem: str, *, line: int | None = None, field: str | None = None) -> None:
        place = str(path) + (f":{line}" if line is not None else "") + (f": {field}" if field else "")
        super().__init__(f"{place}: {problem}")
        self.path, self.line, self.field, self.problem = Path(path), line, field, problem


class NotFound(ArraMonError):
    """What was asked for does not exist; the message names what does."""


class Conflict(ArraMonError):
    """The request does not fit the present state, such as the scores of a run that is still being played."""


class TakenOver(Conflict):
    """Another process of this server has got there first. Whoever reads this tries again, and sees what is now."""


class Unauthenticated(ArraMonError):
    """The caller gave no token where one is needed, or one that is not good; the message says what to do."""


class Forbidden(ArraMonError):
    """The server knows the caller, or needs not to, and will not do this for them."""


class OverQuota(ArraMonError):
    """A participant's limit is reached; the message names it, what counts, and when the next is possible."""


class Unavailable(ArraMonError):
    """The server cannot go on just now, such as while it shuts down. Nothing that was answered is lost."""


class StorageError(Unavailable):
    """The journal or the data folder could not be read or written. Nothing that was answered is lost."""
