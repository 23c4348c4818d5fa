"""Processes that end with their parent, so that none outlives a program that is killed: a launcher, and a watch.

The launcher runs a module as a program, whose standard input ends with its parent, which never writes to it; it then
sends itself SIGTERM. The watch is for processes that `multiprocessing` has started. Neither relies on pipes alone: a
process that was forked from the parent meanwhile holds their other ends open.
"""

import multiprocessing
import os
import runpy
import signal
import sys
import threading
from collections.abc import Callable
from multiprocessing.connection import wait

LOOK_SECONDS = 0.5
"""Time between two looks at the parent where the system has no handle of processes that could be waited for."""


def end_with_parent() -> None:
    """Watch the parent in a thread, in a process of `multiprocessing`, and end this process with it at once.

    Whatever this process is doing, it ends without clearing up, as if it had been killed with its parent.
    """
    parent = multiprocessing.parent_process()
    assert parent is not None
    assert parent.pid is not None
    _watch([parent.sentinel], parent.pid, lambda: os._exit(1))


def _watch(handles: list[int], parent: int, end: Callable[[], None]) -> threading.Thread | None:
    """Call `end` in a thread once one of the handles becomes readable, or the parent has ended.

    Args:
        handles: that become readable when the parent ends, unless another process holds their other ends.
        parent: its process id.
        end: what is to be done then.

    Returns:
        The thread; None if the parent had ended already.
    """
    started_by = os.getppid()  # The parent, or the server that forks for it, which ends with it.
    watched: list[int] = list(handles)
    if hasattr(os, "pidfd_open"):
        try:
            watched.append(os.pidfd_open(parent))
        except ProcessLookupError:  # It has ended already.
            end()
            return None
        except OSError:  # Not allowed here; the looks remain.
            pass

    def look() -> None:
        while not wait(watched, LOOK_SECONDS):
            if os.getppid() != started_by or not _exists(parent):
                break
        end()

    thread = threading.Thread(target=look, name="end-with-parent", daemon=True)
    thread.start()
    return thread


def _exists(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        return True
    return True


def stop_with_parent() -> None:
    """Watch the parent in a thread, and send this process SIGTERM when it ends, or standard input does."""
    # Standard input becomes readable when it ends: the parent never writes to it.
    _watch([0], os.getppid(), lambda: os.kill(os.getpid(), signal.SIGTERM))


def main(arguments: list[str]) -> None:
    """Run the module `arguments[0]` as a program, with the remaining arguments."""
    stop_with_parent()
    sys.argv = arguments
    runpy.run_module(arguments[0], run_name="__main__", alter_sys=True)


if __name__ == "__main__":
    main(sys.argv[1:])
