"""Cleanup of what a program may forget to close: at the program's end, while its threads still run.

Python closes a context manager that is never left when it deletes the generator behind it, which may be during the
interpreter's shutdown. Daemon threads have been stopped by then, so that a cleanup that waits for one never ends.
"""

import os
import weakref
from collections.abc import Callable


def close_once(owner: object, close: Callable[[], None]) -> Callable[[], None]:
    """Return a function that calls `close` when it is called first, or at the end of the program if it was not.

    At the end of the program what was opened last is closed first. A forked process closes nothing: it all belongs to
    its parent, and the threads that a cleanup waits for exist only there.

    Args:
        owner: what is to be closed, or lives as long; if it is deleted, `close` is called, too.
        close: the cleanup; a reference to `owner` in it keeps `owner` alive until the cleanup.
    """
    process = os.getpid()

    def close_in_this_process() -> None:
        if os.getpid() == process:
            close()

    return weakref.finalize(owner, close_in_this_process)
