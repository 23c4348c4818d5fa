"""Threads that compress images beside drawing."""

import threading
from collections.abc import Callable

import pytest

from server.api.encoding_threads import EncodingThreads


def test_work_is_done_beside_the_caller() -> None:
    begun = threading.Event()

    def work() -> str:
        begun.set()
        return threading.current_thread().name

    finish = EncodingThreads(cores=2).begin(work)
    assert begun.wait(60.0)  # Without being finished by the caller.
    assert finish().startswith("encode")


def test_the_caller_does_what_no_thread_has_begun() -> None:
    threads, release = EncodingThreads(cores=2), threading.Event()
    busy = threads.begin(release.wait)
    waiting = threads.begin(threading.current_thread)
    assert waiting() is threading.current_thread()
    release.set()
    assert busy()


def test_a_single_core_has_no_threads() -> None:
    assert EncodingThreads(cores=1).begin(threading.current_thread)() is threading.current_thread()


@pytest.mark.parametrize("cores", [1, 2])
def test_errors_reach_the_caller(cores: int) -> None:
    finish: Callable[[], float] = EncodingThreads(cores).begin(lambda: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        finish()
