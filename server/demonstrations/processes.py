"""Work on all cores: results come as they are ready, and no process outlives its parent."""

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from multiprocessing.connection import wait
from typing import TypeVar

from server.errors import ArraMonError

_Job = TypeVar("_Job")
_Result = TypeVar("_Result")


def run_all(work: Callable[[_Job], _Result], jobs: Sequence[_Job], processes: int) -> Iterator[_Result]:
    """Yield the results of all jobs as they are ready; in order and in this process if `processes` is 1.

    Where one fails, those that are being worked on are finished first.

    Args:
        work: a function of a module, so that it can be named to other processes.
        jobs: what it is called with.
        processes: their number.

    Raises:
        ArraMonError: if a process died, or `work` raised it.
        OSError: if `work` raised it.
    """
    if processes == 1:
        yield from map(work, jobs)
        return
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(processes, mp_context=context, initializer=_end_with_parent)
    has_failed = False
    try:
        for future in as_completed([pool.submit(work, job) for job in jobs]):
            yield future.result()
    except BrokenProcessPool as error:
        raise ArraMonError("a process that renders demonstrations died, possibly out of memory") from error
    except (ArraMonError, OSError):
        has_failed = True
        raise
    finally:
        pool.shutdown(wait=has_failed, cancel_futures=True)


def _end_with_parent() -> None:
    """End this process with its parent, however that ends; leave keyboard interrupts to it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    assert parent is not None

    def watch() -> None:
        wait([parent.sentinel])
        os._exit(1)

    threading.Thread(target=watch, name="end-with-parent", daemon=True).start()
