"""Processes of `--jobs` end with the command, also if another process holds the ends of its pipes."""

import os
import signal
from pathlib import Path

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
