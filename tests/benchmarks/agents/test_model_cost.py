"""Calls and tokens of an episode, measured with real clients and a fake endpoint."""

import sys
from argparse import Namespace
from pathlib import Path

import pytest

pytest.importorskip("openai", reason="the extra `vlm` is not installed: scripts/setup")

from benchmarks.agents import model_cost
from tests import tiny
from tests.agents.vlm import runs


def test_the_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    runs.write(tmp_path, 2)
    options = ["--data", str(tmp_path), "--plans", "2", "--windows", "1", "--episodes", "2"]
    monkeypatch.setattr(sys, "argv", ["model_cost", *options])
    model_cost.main()
    header, _, row = capsys.readouterr().out.splitlines()
    assert header == "| plan | window | episodes | steps | calls | tokens read | cached | tokens written |"
    *settings, steps, calls, read, cached, _ = row.strip("| ").split(" | ")
    assert settings == ["2", "1", "2"]
    assert (int(steps), int(calls)) == (len(tiny.ACTIONS), runs.CALLS)
    assert int(read.replace(",", "")) > int(cached.replace(",", "")) > 0


def test_what_a_failed_client_says_is_shown(tmp_path: Path) -> None:
    given = Namespace(lang="en", episodes=1, words=False)
    with pytest.raises(SystemExit, match="the client ended with status"):
        model_cost.measure(tmp_path, "nowhere", {}, 1, 0, given)
