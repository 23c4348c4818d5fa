"""Which agents play with which weights for the tables of results."""

from pathlib import Path

import pytest

pytest.importorskip("torch", reason="the extra `agents` is not installed: scripts/setup")

from benchmarks.agents.results import players_of


def test_an_agent_plays_with_the_folders_that_have_its_weights(tmp_path: Path) -> None:
    folders = [tmp_path / name for name in ("a", "b", "c")]
    for folder, agents in zip(folders, (["vl", "vl_map"], ["vl_map"], ["vl"]), strict=True):
        folder.mkdir()
        for agent in agents:
            (folder / f"{agent}.safetensors").write_bytes(folder.name.encode())
    assert [(player.seed, player.weights) for player in players_of("vl", folders)] == [
        (1, folders[0] / "vl.safetensors"),
        (3, folders[2] / "vl.safetensors"),
    ]
    first, second = players_of("vl_map+segmentation", folders)
    assert first.name == "vl_map sensor=segmentation"
    assert first.arguments == {"weights": str(folders[0] / "vl_map.safetensors"), "sensor": "segmentation"}
    assert first.mark != second.mark
    assert [player.arguments for player in players_of("random_walk", folders)] == [{"seed": seed} for seed in range(3)]
    with pytest.raises(SystemExit, match="there are no weights of vl_grounded in"):
        players_of("vl_grounded", folders)
