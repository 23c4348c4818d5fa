"""Parallel jobs whose results are yielded as they complete; if one fails, running jobs are finished first."""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import as_completed
from typing import TypeVar

from arramon_dataset.parallel import process_pool
from arramon_server.errors import ArraMonError

_Job = TypeVar("_Job")
_Result = TypeVar("_Result")


def run_jobs(work: Callable[[_Job], _Result], jobs: Sequence[_Job], processes: int) -> Iterator[_Result]:
    """Yield the results of all jobs as they are ready; in order and in this process if `processes` is 1.

    If one fails, the jobs that are running are finished first.

    Args:
        work: a module-level function, as it is pickled by name.
        jobs: arguments of its calls.
        processes: number of processes.

    Raises:
        ArraMonError: if a process died, or `work` raised it.
        OSError: if `work` raised it.
    """
    if processes == 1:
        yield from map(work, jobs)
        return
    with process_pool(processes, "renders demonstrations") as pool:
        try:
            for future in as_completed([pool.submit(work, job) for job in jobs]):
                yield future.result()
        except (ArraMonError, OSError):
            pool.shutdown(wait=True, cancel_futures=True)
            raise
