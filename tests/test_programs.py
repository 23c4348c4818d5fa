"""External programs under test end when the tests say so."""

import os
import signal
import sys
import time
from pathlib import Path

from tests.programs import start, stop

PROGRAM = """
import signal
signal.signal(signal.SIGINT, signal.SIG_DFL)
print("ready", flush=True)
signal.pause()
"""
"""Ends by an interrupt, though shells start what runs beside them with interrupts ignored."""


def test_a_program_stops_although_a_forked_process_holds_its_input(tmp_path: Path) -> None:
    """Processes that tests fork hold the ends of all pipes, and may go on."""
    log = tmp_path / "log"
    process = start([sys.executable, "-c", PROGRAM], log)
    while not log.stat().st_size:
        time.sleep(0.01)
    child = os.fork()
    if child == 0:
        time.sleep(1000)
        os._exit(0)
    try:
        stop(process)
    finally:
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
    assert process.returncode is not None


SLOW = """
import signal, sys, time
from pathlib import Path

def end(*_):
    print("ending", flush=True)
    time.sleep(0.5)
    Path(sys.argv[1]).touch()
    sys.exit()

signal.signal(signal.SIGINT, end)
print("ready", flush=True)
while True:
    signal.pause()
"""
"""Takes its time to end."""


def test_a_program_that_is_stopped_has_ended(tmp_path: Path) -> None:
    log, ended = tmp_path / "log", tmp_path / "ended"
    process = start([sys.executable, "-c", SLOW, str(ended)], log)
    while "ready" not in log.read_text():
        time.sleep(0.01)
    assert process.stdin is not None
    process.stdin.close()
    while "ending" not in log.read_text():
        time.sleep(0.01)
    stop(process)
    assert ended.exists()
