"""Tracebacks for an agent's author, without the frames of this client and of Python's import machinery."""

import importlib
import traceback
from pathlib import Path

_FOREIGN = (str(Path(__file__).parents[1]), str(importlib.__file__), "<frozen importlib", "<frozen runpy")


def own_frames(error: BaseException, limit: int = 12) -> str:
    """Format an exception's traceback without the frames of this client and of the import machinery.

    Args:
        error: the exception, with its causes.
        limit: number of innermost frames to keep.

    Returns:
        Python's traceback text, shortened; several lines, without a newline at the end.
    """
    summary = traceback.TracebackException.from_exception(error, compact=True)
    part: traceback.TracebackException | None = summary
    while part is not None:
        frames = [frame for frame in part.stack if not _is_foreign(frame.filename)]
        part.stack = traceback.StackSummary.from_list(frames[-limit:])
        part = part.__cause__ or part.__context__
    return "".join(summary.format()).rstrip()


def _is_foreign(filename: str) -> bool:
    return filename.startswith(_FOREIGN)
