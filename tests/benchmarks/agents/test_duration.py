"""Playing speed of agents, measured with real clients."""

import sys
from argparse import Namespace
from pathlib import Path

import pytest

from benchmarks.agents import duration
from tests import tiny


def test_clients_in_both_languages_are_timed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    tiny.write(tmp_path, "val_seen", 2)
    found, play = [], duration.play

    def play_and_keep(agent: str, languages: list[str], given: Namespace) -> tuple[float, int, float]:
        found.append(play(agent, languages, given))
        return found[-1]

    monkeypatch.setattr(duration, "play", play_and_keep)
    options = ["--data", str(tmp_path), "--agents", "stop", "--episodes", "1", "--parallel", "1"]
    monkeypatch.setattr(sys, "argv", ["duration", *options])
    duration.main()
    ((seconds, steps, start),) = found
    assert steps == 2 * 2 * (150 + 1)  # In two languages, two turns: a street to the step limit, and a room.
    assert 0.0 < seconds < start
    header, _, row = capsys.readouterr().out.splitlines()
    assert header == "| agent | steps/s | ratio | start, s | minutes for 1,155 | CPU s per episode |"
    assert row.startswith(f"| `stop` | {steps / seconds:.0f} | 1.00 | ")
    assert 0.1 < float(row.rstrip(" |").rpartition(" ")[2]) < 100.0


def test_what_a_failed_client_says_is_told(tmp_path: Path) -> None:
    client = Path(sys.executable).with_name("arramon-client")
    given = Namespace(data=tmp_path, split="val_seen", episodes=1, parallel=1, client=client)
    with pytest.raises(SystemExit, match="nowhere did not finish its run:\nerror: no agent"):
        duration.play("nowhere", ["en"], given)
