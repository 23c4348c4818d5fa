"""Selection of agents and weights for the tables of results."""

import sys
from pathlib import Path

import pytest

pytest.importorskip("torch", reason="the extra `agents` is not installed: scripts/setup")

from benchmarks.agents import results
from tests import tiny


def test_an_agent_plays_with_the_folders_that_have_its_weights(tmp_path: Path) -> None:
    folders = [tmp_path / name for name in ("a", "b", "c")]
    for folder, agents in zip(folders, (["vl", "vl_map"], ["vl_map"], ["vl"]), strict=True):
        folder.mkdir()
        for agent in agents:
            (folder / f"{agent}.safetensors").write_bytes(folder.name.encode())
    assert [(player.seed, player.weights) for player in results.setups_of("vl", folders)] == [
        (1, folders[0] / "vl.safetensors"),
        (3, folders[2] / "vl.safetensors"),
    ]
    first, second = results.setups_of("vl_map+segmentation", folders)
    assert first.name == "vl_map sensor=segmentation"
    assert first.arguments == {"weights": str(folders[0] / "vl_map.safetensors"), "sensor": "segmentation"}
    assert first.run_name != second.run_name
    assert [player.arguments for player in results.setups_of("random_walk", folders)] == [
        {"seed": seed} for seed in range(3)
    ]
    with pytest.raises(SystemExit, match="there are no weights of vl_grounded in"):
        results.setups_of("vl_grounded", folders)


@pytest.mark.slow
def test_the_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Also that nothing is played again."""
    tiny.write(tmp_path, "val_seen", 2)
    tiny.write(tmp_path, "test_unseen", 2, hidden=True)
    page = tmp_path / "page.md"
    page.write_text(f"Before.\n{results.BEGIN}\n{results.END}\nAfter.\n")
    options = ["--data", str(tmp_path), "--runs", str(tmp_path / "runs"), "--page", str(page), "--episodes", "1"]
    options += ["--agents", "stop", "--hidden-agents", "stop", "--splits", "val_seen"]
    monkeypatch.setattr(sys, "argv", ["results", *options])
    results.main()
    text = page.read_text()
    assert text.startswith("Before.\n")
    assert text.endswith("After.\n")
    for heading in ("## val_seen", "## test_unseen"):
        assert heading in text
    assert text.count("| `stop` | en | ") >= 2
    monkeypatch.setattr(results, "_play_run", None)
    results.main()
    assert page.read_text() == text
