"""Threads that draw and compress images."""

import threading
import time
from collections.abc import Callable
from functools import partial

import pytest

from arramon_server.image_threads import ImageThreads


def test_work_is_done_beside_the_caller() -> None:
    begun = threading.Event()

    def work() -> str:
        begun.set()
        return threading.current_thread().name

    finish = ImageThreads(cores=2).begin(work)
    assert begun.wait(60.0)  # Without being finished by the caller.
    assert finish().startswith("images")


def test_the_caller_does_what_no_thread_has_begun() -> None:
    threads, release = ImageThreads(cores=2), threading.Event()
    busy = threads.begin(release.wait)
    waiting = threads.begin(threading.current_thread)
    assert waiting() is threading.current_thread()
    release.set()
    assert busy()


def test_a_single_core_has_no_threads() -> None:
    assert ImageThreads(cores=1).begin(threading.current_thread)() is threading.current_thread()


@pytest.mark.parametrize("cores", [1, 2])
def test_errors_reach_the_caller(cores: int) -> None:
    finish: Callable[[], float] = ImageThreads(cores).begin(lambda: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        finish()


@pytest.mark.parametrize("cores", [1, 2, 4])
@pytest.mark.parametrize("count", [0, 1, 2, 9])
def test_results_are_in_order(cores: int, count: int) -> None:
    works = [partial(int, number) for number in range(count)]
    assert ImageThreads(cores).run(works) == list(range(count))


def test_work_is_shared_with_the_caller() -> None:
    """Neither of two pieces of work ends before the other has begun."""
    meeting = threading.Barrier(2, timeout=60.0)

    def work() -> str:
        meeting.wait()
        return threading.current_thread().name

    names = ImageThreads(cores=2).run([work, work])
    assert threading.current_thread().name in names
    assert len(set(names)) == 2


@pytest.mark.parametrize("cores", [1, 2])
@pytest.mark.parametrize("wrong", [0, 1, 2])
def test_errors_of_shared_work_reach_the_caller(cores: int, wrong: int) -> None:
    works = [partial(divmod, 1, number) for number in (1, 1, 1)]
    works[wrong] = partial(divmod, 1, 0)
    with pytest.raises(ZeroDivisionError):
        ImageThreads(cores).run(works)


def test_nothing_goes_on_after_an_error() -> None:
    begun, working = threading.Event(), []

    def slow() -> None:
        working.append(True)
        begun.set()
        time.sleep(0.2)
        working.pop()

    def fail() -> None:
        assert begun.wait(60.0)
        raise ValueError("expected")

    with pytest.raises(ValueError, match="expected"):
        ImageThreads(cores=2).run([fail, slow])
    assert not working
