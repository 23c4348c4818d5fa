"""Killed generation: no partial split and no process remain, and the next call resumes."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.dataset.generation import small_batches
from tests.forked import run

SERVER = [sys.executable, "-m", "tests.dataset.generation.small_batches"]


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
    arguments = ["generate", "--data", str(tmp_path / "data"), "--split", "val_unseen", "--jobs", "2", "--no-trial"]
    with subprocess.Popen(
        [*SERVER, *arguments], stderr=subprocess.PIPE, text=True, start_new_session=True
    ) as generation:
        assert generation.stderr is not None
        assert generation.stderr.readline().startswith("val_unseen: 0 of ")
        assert generation.stderr.readline().startswith("val_unseen: ")
        assert len(processes_in_group(generation.pid)) >= 3

        os.kill(generation.pid, signal.SIGKILL)
        generation.wait()
        for _ in range(1200):
            if not processes_in_group(generation.pid):
                break
            time.sleep(0.1)

        assert processes_in_group(generation.pid) == []
        assert not (tmp_path / "data" / "splits").exists()


@pytest.mark.slow
@pytest.mark.parametrize("end", [os.kill, os.killpg], ids=["its process", "its group"])
def test_terminated_generation_says_so_in_one_line(tmp_path: Path, end: Callable[[int, int], None]) -> None:
    """Service managers signal all processes of a group."""
    arguments = ["generate", "--data", str(tmp_path / "data"), "--split", "val_unseen", "--jobs", "2", "--no-trial"]
    with subprocess.Popen(
        [*SERVER, *arguments], stderr=subprocess.PIPE, text=True, start_new_session=True
    ) as generation:
        assert generation.stderr is not None
        for _ in range(2):
            assert generation.stderr.readline().startswith("val_unseen: ")

        end(generation.pid, signal.SIGTERM)
        said = generation.stderr.read().splitlines()

        assert generation.wait() == 128 + signal.SIGTERM
        assert [line for line in said if not line.startswith("val_unseen: ")] == ["arramon-server: stopped by SIGTERM"]


OPTIONS = ("--split", "val_unseen", "--scale", "0.0026", "--jobs", "1", "--no-trial")
"""Of three episodes."""


def finish(data: Path) -> tuple[str, dict[str, bytes]]:
    """Generate to the end; returns what was printed about it, and the files of the data folder."""
    done = run("generate", "--data", data, *OPTIONS, command=small_batches.main)
    assert done.returncode == 0, done.stderr
    return done.stderr, {str(path.relative_to(data)): path.read_bytes() for path in data.rglob("*") if path.is_file()}


@pytest.mark.slow
def test_generation_goes_on_where_it_was_killed(tmp_path: Path) -> None:
    """The files are those of a generation that nothing disturbed, and what was made before is not made again."""
    killed = subprocess.Popen(
        [*SERVER, "generate", "--data", str(tmp_path / "killed"), *OPTIONS], stderr=subprocess.DEVNULL
    )
    unfinished = tmp_path / "killed" / "unfinished" / "val_unseen.jsonl"
    while killed.poll() is None and not (unfinished.exists() and unfinished.read_bytes().count(b"\n") > 1):
        time.sleep(0.02)
    os.kill(killed.pid, signal.SIGKILL)
    assert killed.wait() == -signal.SIGKILL
    kept = unfinished.read_bytes().count(b"\n") - 1

    output, files = finish(tmp_path / "killed")

    assert 1 <= kept < 3
    assert output.startswith(f"val_unseen: going on after {kept} of 3 episodes\n")
    assert files == finish(tmp_path / "undisturbed")[1]
    assert not unfinished.parent.exists()
