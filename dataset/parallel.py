"""Process pools: the number of processes of a command, and a pool whose processes end with their parent."""

import multiprocessing
import os
import signal
import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import resource_tracker
from typing import Any

from arramon_client.local.cores import usable_cores
from arramon_client.local.lifeline import end_with_parent
from arramon_server.errors import ArraMonError, BadInput

MAX_JOBS = 256

TERMINATED_AFTER = 3.0
"""Seconds until a process of a pool ends by SIGTERM. Service managers send it to all processes of a group: the parent
must stop the work before its processes are gone. They end as soon as it has ended."""

STOP_SIGNALS = (signal.SIGINT, signal.SIGTERM)
"""Blocked in a process of a pool until it has set its handlers: while it starts, they would end it at once."""

_left: list[ProcessPoolExecutor] = []
"""Pools that were left. One that is collected before its thread has seen the shutdown does not take the cancelled work
from its list; when a process of it is terminated then, the thread ends with a traceback (Python 3.11)."""


def processes_of(jobs: int) -> int:
    """Return the number of processes for the option `--jobs`: 0 is one for each core.

    Raises:
        BadInput: if it is not from 0 to MAX_JOBS.
    """
    if not 0 <= jobs <= MAX_JOBS:
        raise BadInput(f"the number of jobs is {jobs}; expected 1 to {MAX_JOBS}, or 0 for one per core")
    return jobs or usable_cores()


@contextmanager
def process_pool(
    processes: int, work: str, begin: Callable[..., object] | None = None, *arguments: object
) -> Iterator[ProcessPoolExecutor]:
    """Yield a pool of processes; leaving the block cancels work that has not begun.

    Args:
        processes: their number.
        work: what each of them does, for the error message: "renders demonstrations".
        begin: called with `arguments` in each process before its first task; None for nothing.

    Raises:
        ArraMonError: when results are read inside the block, if a process has died.
    """
    context = multiprocessing.get_context("spawn")
    pool = _Pool(processes, mp_context=context, initializer=_begin, initargs=(begin, arguments))
    try:
        yield pool
    except BrokenProcessPool as error:
        raise ArraMonError(f"a process that {work} died, possibly out of memory") from error
    finally:
        pool.shutdown(wait=False, cancel_futures=True)
        _left.append(pool)


class _Pool(ProcessPoolExecutor):
    """A pool whose processes start with STOP_SIGNALS blocked. Submitting a task may start a process."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        with _blocked(STOP_SIGNALS):
            return super().submit(fn, *args, **kwargs)


@contextmanager
def _blocked(signals: Iterable[int]) -> Iterator[None]:
    """Block signals in this thread, and in the processes that it starts; those that arrive are handled afterwards."""
    resource_tracker.ensure_running()  # `multiprocessing` starts it with the first process, and unblocks all signals.
    before = signal.pthread_sigmask(signal.SIG_BLOCK, signals)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _begin(begin: Callable[..., object] | None, arguments: tuple[object, ...]) -> None:
    """End this process with its parent, however that ends, and leave signals to it; then call `begin`."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, _end_later)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, STOP_SIGNALS)
    end_with_parent()
    if begin is not None:
        begin(*arguments)


def _end_later(number: int, frame: object) -> None:  # noqa: ARG001 - what a signal's handler is called with
    """End this process after TERMINATED_AFTER seconds."""
    time.sleep(TERMINATED_AFTER)
    os._exit(128 + number)
