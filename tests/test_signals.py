"""Programs under test can be stopped, although the tests were started with signals ignored."""

import signal
import subprocess
import sys

import pytest

from tests import ROOT
from tests.signals import SIGNALS

PROGRAM = """
import os, signal, subprocess, sys
from tests.signals import let_programs_be_stopped

number = int(sys.argv[1])
signal.signal(number, signal.SIG_IGN)
let_programs_be_stopped()
os.kill(os.getpid(), number)
print("goes on", flush=True)
subprocess.run(["sh", "-c", "kill -$0 $$; echo goes on", str(number)], timeout=120)
"""


@pytest.mark.parametrize("number", SIGNALS)
def test_a_signal_that_was_ignored_stops_programs_but_not_the_tests(number: signal.Signals) -> None:
    command = [sys.executable, "-c", PROGRAM, str(int(number))]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, cwd=ROOT)
    assert (done.returncode, done.stdout) == (0, "goes on\n"), done.stderr
