"""Processes of `--jobs` end with the command, also if another process holds the ends of its pipes, and not before."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tests import ROOT
from tests.client.environments.test_killed import ends, program

POOL = """
import os, sys, time
sys.path.insert(0, {root!r})
from arramon_dataset.parallel import process_pool

if __name__ == "__main__":
    with process_pool(2, "sleeps") as pool:
        ids = {{pool.submit(os.getpid).result() for _ in range(20)}}
        for _ in range(2):
            pool.submit(time.sleep, 1000)
        if os.fork() == 0:
            time.sleep(1000)
        print(os.getpid(), *pool._processes, flush=True)
        time.sleep(1000)
"""


def test_no_process_of_a_pool_outlives_the_command(tmp_path: Path) -> None:
    with program(POOL.format(root=str(ROOT)), tmp_path) as process:
        assert process.stdout is not None
        owner, *workers = map(int, process.stdout.readline().split())
        assert workers
        waits = [ends(worker) for worker in workers]
        os.kill(owner, signal.SIGKILL)
        assert all(has_ended() for has_ended in waits)


SIGNALLED_AT_START = """
import os, signal, sys, time
sys.path.insert(0, {root!r})
from arramon_dataset.parallel import process_pool
from arramon_server.errors import ArraMonError

if __name__ == "__mp_main__":  # in a process of the pool, before its handlers are set
    time.sleep(1)
    print("started", flush=True)
if __name__ == "__main__":
    signal.signal(signal.{name}, lambda *_: None)
    try:
        with process_pool(1, "sleeps") as pool:
            sleeping = pool.submit(time.sleep, 1)
            os.killpg(0, signal.{name})
            sleeping.result()
            print("slept")
    except ArraMonError as error:
        print(error)
"""


@pytest.mark.parametrize(("name", "then"), [("SIGINT", "slept"), ("SIGTERM", "a process that sleeps died")])
def test_a_signal_does_not_end_a_process_that_is_starting(name: str, then: str, tmp_path: Path) -> None:
    """It would end before the command, which would report a broken pool rather than the signal."""
    script = tmp_path / "signalled.py"
    script.write_text(SIGNALLED_AT_START.format(root=str(ROOT), name=name))

    done = subprocess.run([sys.executable, script], capture_output=True, text=True, start_new_session=True)

    assert done.stderr == ""
    started, end = done.stdout.splitlines()
    assert started == "started"
    assert end.startswith(then)


LEFT_BY_SIGNAL = """
import os, signal, sys, time
sys.path.insert(0, {root!r})
from arramon_dataset.parallel import process_pool

def work():
    with process_pool(2, "sleeps") as pool:
        list(pool.map(time.sleep, [0, 0]))  # both have started
        results = pool.map(time.sleep, [0, *[5] * 20])
        next(results)
        os.killpg(0, signal.SIGTERM)
        next(results)

if __name__ == "__main__":
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    sys.setswitchinterval(1)  # the pool's thread runs only after the pool has gone
    try:
        work()
    except KeyboardInterrupt:
        print("stopped")
"""


def test_a_signal_to_all_processes_is_reported_by_the_command_alone(tmp_path: Path) -> None:
    """The pool's thread finds its processes terminated, seconds later, and says nothing."""
    script = tmp_path / "left.py"
    script.write_text(LEFT_BY_SIGNAL.format(root=str(ROOT)))

    done = subprocess.run([sys.executable, script], capture_output=True, text=True, start_new_session=True)

    assert (done.stdout, done.stderr) == ("stopped\n", "")
