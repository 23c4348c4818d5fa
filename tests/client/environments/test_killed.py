"""Processes of a vector environment do not outlive the one that made it, also if others hold the ends of its pipes."""

import multiprocessing
import os
import select
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

MADE = """
import os, sys, time
import gymnasium, numpy as np, arramon_client.environments

def made(data, context, **more):
    return gymnasium.make_vec("arramon/ArraMon-v0", 4, processes=3, context=context, data=data, split="tiny",
                              image_size=16, **more)

def hold():
    "A process that was forked from the owner, and goes on: it holds the ends of all its pipes."
    if os.fork() == 0:
        time.sleep(1000)

if __name__ == "__main__":
    data, context, what = sys.argv[1:]
    if what == "within":  # Owned by a process that another one has forked, and that alone is killed.
        owner = os.fork()
        if owner:
            os.waitpid(owner, 0)
            time.sleep(1000)
    env = made(data, context, batch_size=2 if what == "receiving" else None)
    env.reset(seed=0)
    hold()
    print(os.getpid(), *env.process_ids, flush=True)
    while what == "stepping":
        env.step(np.zeros(4, int))
    while what == "receiving":
        env.send(np.zeros(4, int)) if not env._pool.ready.pending else env.recv()
    time.sleep(1000)
"""

SECONDS = 240.0
"""For which a process that should end at once is waited for: a limit for what hangs."""


def ends(process: int) -> Callable[[], bool]:
    """Return what waits for the end of a process that is not this one's child, from now on."""
    file = os.pidfd_open(process)

    def has_ended() -> bool:
        poll = select.poll()
        poll.register(file, select.POLLIN)
        found = poll.poll(SECONDS * 1e3)
        os.close(file)
        return bool(found)

    return has_ended


@contextmanager
def program(source: str, folder: Path, *arguments: str) -> Iterator["subprocess.Popen[str]"]:
    """A Python program in a session of its own, all of which is killed in the end."""
    path = folder / "program.py"
    path.write_text(source)
    process = subprocess.Popen(
        [sys.executable, str(path), *arguments], stdout=subprocess.PIPE, text=True, start_new_session=True
    )
    try:
        yield process
    finally:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        assert process.stdout is not None
        process.stdout.close()


@pytest.mark.parametrize("what", ["waiting", "stepping", "receiving", "within"])
@pytest.mark.parametrize("context", multiprocessing.get_all_start_methods())
def test_no_worker_outlives_its_owner(data: Path, tmp_path: Path, context: str, what: str) -> None:
    with program(MADE, tmp_path, str(data), context, what) as process:
        assert process.stdout is not None
        owner, *workers = map(int, process.stdout.readline().split())
        assert len(workers) == 2
        waits = [ends(worker) for worker in workers]
        os.kill(owner, signal.SIGKILL)
        assert [has_ended() for has_ended in waits] == [True, True]
