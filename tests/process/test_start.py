"""Servers that are stopped before they serve: they exit at once with status 0."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests import tiny
from tests.process.test_drain import LINUX
from tests.process.test_workers import children


def started(data: Path, *more: str) -> "subprocess.Popen[str]":
    command = [sys.executable, "-m", "arramon_server", "serve", "--data", str(data), "--listen", "127.0.0.1:0", *more]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def ended(process: "subprocess.Popen[str]") -> tuple[int, str, list[str]]:
    """Its status, what it complained of, and whether it said that it listens."""
    process.send_signal(signal.SIGTERM)
    said, complaints = process.communicate(timeout=240)
    return process.returncode, complaints, [line for line in said.splitlines() if line.startswith("listening")]


def test_stopping_while_modules_load_exits_cleanly(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A pipe that a module reads: who opens it to write has met the server in the middle of its imports."""
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    (tmp_path / "numpy.py").write_text(f"open({str(pipe)!r}).read()")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path), prepend=os.pathsep)
    process = started(tmp_path)
    with pipe.open("w"):
        assert ended(process) == (0, "", [])


@pytest.mark.parametrize("workers", ["1", "2"])
def test_stopping_while_reading_splits_exits_cleanly(tmp_path: Path, workers: str) -> None:
    """A pipe in the place of a file: who opens it to write has met the server, which then waits for what is written."""
    tiny.write(tmp_path)
    episodes = tmp_path / "splits" / "tiny" / "episodes.jsonl"
    episodes.unlink()
    os.mkfifo(episodes)
    process = started(tmp_path, "--workers", workers)
    with episodes.open("w"):
        assert ended(process) == (0, "", [])


@LINUX
def test_stopping_while_workers_start_exits_cleanly(tmp_path: Path) -> None:
    tiny.write(tmp_path)
    process = started(tmp_path, "--workers", "2")
    while len(own := children(process.pid)) < 2:
        assert process.poll() is None
        time.sleep(0.01)
    assert ended(process) == (0, "", [])
    assert not [each for each in own if Path(f"/proc/{each}").exists()]
