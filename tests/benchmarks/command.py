"""Runs the benchmarks' commands in forked processes, like `python -m benchmarks.FOLDER.NAME` without the imports."""

import multiprocessing
import re
import runpy
import subprocess
import sys
from functools import partial

import pytest

from tests import forked

NUMBER = r"-?\d+(?:\.\d+)?"


def run(module: str, *arguments: object) -> "subprocess.CompletedProcess[str]":
    """`python -m` with these arguments to its end: its status, and what it said."""
    return forked.run(*arguments, command=partial(run_module, module))


def printed(module: str, *arguments: object) -> list[str]:
    """The lines that `python -m` with these arguments prints; the test fails if the command does."""
    done = run(module, *arguments)
    if done.returncode:
        pytest.fail(f"{module} ended with status {done.returncode}:\n{done.stdout[-2000:]}{done.stderr[-4000:]}")
    return done.stdout.splitlines()


def numbers(lines: list[str], row: str) -> list[float]:
    """The numbers behind the name of a row in a printed table; there is one such row."""
    (line,) = [line for line in lines if line.startswith(row)]
    return [float(number) for number in re.findall(NUMBER, line.removeprefix(row))]


def run_module(module: str, arguments: list[str]) -> int:
    """What `python -m` does, in this process."""
    # Processes that end with the tests may have no children of their own; that is asserted, and this one takes none on.
    multiprocessing.current_process()._config["daemon"] = False  # type: ignore[attr-defined]
    sys.argv = [module, *arguments]
    runpy.run_module(module, run_name="__main__", alter_sys=True)
    return 0
