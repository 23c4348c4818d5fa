"""Environments of other projects, measured in their own interpreters."""

import importlib.util
import sys
from pathlib import Path

import pytest

from benchmarks.simulation.peers import frames_per_second
from tests.benchmarks.command import printed, run


def test_an_environment_that_is_not_installed() -> None:
    if importlib.util.find_spec("minigrid"):
        pytest.skip("minigrid is installed")
    assert run("benchmarks.simulation.peers", "babyai").returncode == 3
    assert frames_per_second(sys.executable, "babyai", 0.1) is None


def test_frames() -> None:
    if importlib.util.find_spec("minigrid") is None:
        pytest.skip("minigrid is not installed: pip install minigrid")
    (rate,) = printed("benchmarks.simulation.peers", "babyai", "--seconds", 0.1)
    assert float(rate) > 0


def test_an_interpreter_that_fails_is_told(tmp_path: Path) -> None:
    broken = tmp_path / "python"
    broken.write_text("#!/bin/sh\necho no display >&2\nexit 1\n")
    broken.chmod(0o755)
    with pytest.raises(SystemExit, match=r"miniworld cannot be measured with .*\nno display"):
        frames_per_second(str(broken), "miniworld", 0.1)
