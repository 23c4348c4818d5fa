"""The table of agents on people's instructions: means, errors, and which reader played."""

from pathlib import Path

import pytest

torch = pytest.importorskip("torch", reason="the extra `agents` is not installed: scripts/setup")

from benchmarks.agents import people_agents as script  # noqa: E402


def test_table(tmp_path: Path) -> None:
    reader = tmp_path / "reader.safetensors"
    reader.write_bytes(b"weights")
    names = (*script.METRICS, script.ALONE)
    scores = {str(number): dict.fromkeys(names, float(number)) for number in range(2)}
    plain, tuned, rules = (
        script.Player("vl_map", None), script.Player("vl_map", reader), script.Player("follower", None),
    )  # fmt: skip
    lines = script.table([(plain, scores), (tuned, scores), (rules, scores)]).splitlines()
    assert lines[0] == "| agent | trained on | episodes | nDTW | CTC-3 | PTC@CTC-3 | PTC alone |"
    assert lines[2].startswith("| `vl_map` | generated text | 2 | 0.500 ± 0.500 |")
    assert "reader fine-tuned on people's" in lines[3]
    assert lines[4].startswith("| `follower` | - | 2 |")


def test_another_reader_has_other_runs(tmp_path: Path) -> None:
    reader = tmp_path / "reader.safetensors"
    reader.write_bytes(b"weights")
    plain, tuned = script.Player("vl_map", None), script.Player("vl_map", reader)
    assert plain.mark != tuned.mark
    assert script.Player("vl", None).mark == "vl"
    assert (plain.arguments, tuned.arguments) == ({}, {"reader": str(reader)})
