"""Killed generation: no partial split and no process remain."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest


def processes_in_group(group: int) -> list[str]:
    """The commands of the processes of a group that have not ended."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            status = (folder / "stat").read_text().rpartition(")")[2].split()
            if int(status[2]) == group and status[0] != "Z":
                found.append((folder / "cmdline").read_text())
        except (FileNotFoundError, ProcessLookupError):
            continue
    return found


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="counts processes in /proc, which this system lacks")
def test_killed_generation_leaves_no_split_and_no_process(tmp_path: Path) -> None:
    arguments = ["generate", "--data", str(tmp_path / "data"), "--split", "val_unseen", "--jobs", "2"]
    command = [sys.executable, "-m", "server", *arguments]
    run = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, start_new_session=True)
    assert run.stderr is not None
    assert run.stderr.readline().startswith("val_unseen: ")
    assert len(processes_in_group(run.pid)) >= 3

    os.kill(run.pid, signal.SIGKILL)
    run.wait()
    for _ in range(1200):
        if not processes_in_group(run.pid):
            break
        time.sleep(0.1)

    assert processes_in_group(run.pid) == []
    assert not (tmp_path / "data" / "splits").exists()
    run.stderr.close()
