"""Child processes that end when their parent does, so that none outlives a program that is killed.

`main` launches a module as a program that sends itself SIGTERM when its parent ends, which also closes its standard
input. `end_with_parent` is for processes started by `multiprocessing`. Neither relies on pipes alone: another process
forked from the parent may hold their other ends open.
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
"""Polling interval for the parent on systems without process handles that can be waited for."""


def end_with_parent() -> None:
    """Make this `multiprocessing` child exit as soon as its parent ends, by watching the parent in a thread.

    The process exits without any cleanup, as if it had been killed with its parent.
    """
    parent = multiprocessing.parent_process()
    assert parent is not None
    assert parent.pid is not None
    _watch([parent.sentinel], parent.pid, lambda: os._exit(1))


def _watch(handles: list[int], parent: int, end: Callable[[], None]) -> threading.Thread | None:
    """Call `end` in a thread once one of the handles becomes readable, or the parent has ended.

    Args:
        handles: file descriptors that become readable when the parent ends, unless another process holds their other
            ends.
        parent: the parent's process id.
        end: called when the parent has ended.

    Returns:
        The thread; None if the parent had already ended.
    """
    started_by = os.getppid()  # The parent, or the fork server, which ends with it.
    watched: list[int] = list(handles)
    if hasattr(os, "pidfd_open"):
        try:
            watched.append(os.pidfd_open(parent))
        except ProcessLookupError:  # The parent has already ended.
            end()
            return None
        except OSError:  # Not permitted here; polling remains.
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
    """Watch the parent in a thread, and send this process SIGTERM when the parent or standard input ends."""
    # Standard input becomes readable when it ends: the parent never writes to it.
    _watch([0], os.getppid(), lambda: os.kill(os.getpid(), signal.SIGTERM))


def main(arguments: list[str]) -> None:
    """Run the module `arguments[0]` as a program, with the remaining arguments."""
    stop_with_parent()
    sys.argv = arguments
    runpy.run_module(arguments[0], run_name="__main__", alter_sys=True)


if __name__ == "__main__":
    main(sys.argv[1:])
