"""Tracebacks as an agent's author wants to read them: their own frames, without those of this client."""

import importlib
import traceback
from pathlib import Path

_FOREIGN = (str(Path(__file__).parent), str(importlib.__file__), "<frozen importlib", "<frozen runpy")


def own_frames(error: BaseException, limit: int = 12) -> str:
    """The traceback of `error` from the first frame that is neither this client's nor the import machinery's.

    Args:
        error: an exception that was caught.
        limit: the number of frames to keep, the innermost ones.

    Returns:
        The text that Python would print, shortened; several lines, without a newline at its end.
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
