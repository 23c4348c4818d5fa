"""The table of agents on people's instructions: means, standard errors, and the reader that played."""

import json
import sys
from pathlib import Path

import pytest

torch = pytest.importorskip("torch", reason="the extra `agents` is not installed: scripts/setup")

from benchmarks.agents import people_agents as script  # noqa: E402
from tests import tiny  # noqa: E402


def test_table(tmp_path: Path) -> None:
    reader = tmp_path / "reader.safetensors"
    reader.write_bytes(b"weights")
    names = (*script.METRICS, script.ALONE)
    scores = {str(number): dict.fromkeys(names, float(number)) for number in range(2)}
    plain, tuned, rules = (
        script.TunedAgent("vl_map"),
        script.TunedAgent("vl_map", reader),
        script.TunedAgent("follower"),
    )
    lines = script.table([(plain, scores), (tuned, scores), (rules, scores)]).splitlines()
    assert lines[0] == "| agent | trained on | episodes | nDTW | CTC-3 | PTC@CTC-3 | PTC alone |"
    assert lines[2].startswith("| `vl_map` | generated text | 2 | 0.500 ± 0.500 |")
    assert "reader fine-tuned on people's" in lines[3]
    assert lines[4].startswith("| `follower` | - | 2 |")


def test_other_weights_and_another_reader_have_other_runs(tmp_path: Path) -> None:
    for name in ("reader", "vl"):
        (tmp_path / f"{name}.safetensors").write_bytes(b"weights")
    players = script.setups_of(["vl_map", "vl", "follower"], tmp_path)
    assert [(each.agent, list(each.arguments)) for each in players] == [
        ("vl_map", []), ("vl_map", ["reader"]), ("vl", []), ("vl", ["weights"]), ("follower", []),
    ]  # fmt: skip
    marks = [each.run_name for each in players]
    assert len(set(marks)) == 5
    assert marks[-1] == "follower"
    assert players[3].trained == "generated text, agent fine-tuned on people's"
    assert script.setups_of(["vl"], None) == [script.TunedAgent("vl")]


def test_what_fine_tuning_changes(tmp_path: Path) -> None:
    names = (*script.METRICS, script.ALONE)
    before, after = ({str(at): dict.fromkeys(names, at / 4 + more) for at in range(3)} for more in (0.0, 0.25))
    rows = [(script.TunedAgent("vl"), before), (script.TunedAgent("vl", None, tmp_path / "vl.safetensors"), after)]
    lines = script.tuned_table(rows).splitlines()
    assert lines[-1].startswith("| `vl` | **+0.250 (+0.250 to +0.250)** |")
    assert script.tuned_table(rows[:1]) == ""


def test_the_command_plays_every_other_episode(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    tiny.write(tmp_path, "val_seen", 3)
    page = tmp_path / "page.md"
    page.write_text(f"{script.BEGIN}\n{script.END}\n")
    options = ["--agents", "random_walk", "--episodes", "0", "--runs", str(tmp_path / "runs"), "--page", str(page)]
    monkeypatch.setattr(sys, "argv", ["people_agents", str(tmp_path), *options])
    script.main()
    (kept,) = (tmp_path / "runs").glob("*.json")
    assert set(json.loads(kept.read_text())) == {"0", "2"}
    assert "| `random_walk` | - | 2 | " in page.read_text()
