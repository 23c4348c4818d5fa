"""Programs and forked processes that hang are aborted, and show where they were."""

import multiprocessing
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from typing import Any

import pytest

from tests import forked, limits

HANGS = """
import time
def hang():
    print("begun", flush=True)
    time.sleep(1000)
hang()
"""


def hang(_arguments: list[str]) -> int:
    os.write(1, b"begun\n")
    time.sleep(1000)
    return 0


@pytest.mark.parametrize("end", [subprocess.Popen.wait, subprocess.Popen.communicate])
def test_a_program_that_hangs_is_aborted_and_shows_its_stack(
    end: Callable[["subprocess.Popen[str]"], Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(limits, "LIMIT", 0.1)
    monkeypatch.setattr(limits, "HANGING", 0.0)
    pipe = subprocess.PIPE
    with subprocess.Popen([sys.executable, "-c", HANGS], stdout=pipe, stderr=pipe, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "begun\n"
        with pytest.raises(subprocess.TimeoutExpired) as caught:
            end(process)
    assert "in hang" in "".join(caught.value.__notes__)


def test_a_forked_command_that_hangs_is_aborted_and_shows_its_stack() -> None:
    said, says = multiprocessing.Pipe(duplex=False)
    with said, says:
        process = forked.Forked([], says, None, hang)
        output = os.fdopen(os.dup(said.fileno()))
    assert output.readline() == "begun\n"
    with pytest.raises(AssertionError, match=r"did not end within 0\.1 s: (.*\n)*.* in hang\n"):
        forked.read_to_end(process, output, 0.1)
    assert process.wait() == -signal.SIGABRT
