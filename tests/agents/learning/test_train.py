"""The command that trains: a smoke test for each agent that comes along, from episodes to a run with its weights."""

from pathlib import Path

import pytest
import torch

from agents import train
from agents.learning.checkpoint import load_policy
from agents.learning.recipe import RECIPES
from agents.learning.rollouts import Plan, play
from agents.vl_grounded.weights import read_weights
from agents.vl_map.weights import read_policy
from arramon_client import load_agent


@pytest.mark.parametrize("agent", RECIPES)
def test_smoke(agent: str, data: Path, tmp_path: Path) -> None:
    folders = ["--data", str(data), "--cache", str(tmp_path / "cache"), "--output", str(tmp_path / "out")]
    assert train.main(["--agent", agent, "--smoke", "--encoder", "pooled", *folders]) == 0
    weights = tmp_path / "out" / f"{agent}.safetensors"
    policy = load_policy(weights)
    assert policy.about["recipe"]["agent"] == agent
    assert set(policy.about["validation"]) == {"navigation", "assembly"}
    assert f"python -m agents.train --agent {agent} --lang en,hi" in weights.with_suffix(".md").read_text()
    assert list((tmp_path / "out" / "log" / agent).iterdir())
    played = load_agent(f"agents.{agent}", {"weights": str(weights)})
    assert len(play(played, Plan(data, "val_seen", ("en",), 1, 224))) == 1


def test_smoke_of_the_grounded_agent(data: Path, tmp_path: Path) -> None:
    """Its training goes on from its saved state with the same outcome, and refuses options of other agents."""
    folders = ["--data", str(data), "--cache", str(tmp_path / "cache"), "--output", str(tmp_path / "out")]
    command = ["--agent", "vl_grounded", "--smoke", *folders]
    assert train.main(command) == 0
    weights = tmp_path / "out" / "vl_grounded.safetensors"
    first = read_weights(weights)
    assert set(first.about["validation"]) == {"nDTW", "CTC-3", "PTC"}
    assert "python -m agents.train --agent vl_grounded --lang en,hi" in weights.with_suffix(".md").read_text()
    played = load_agent("agents.vl_grounded", {"weights": str(weights)})
    assert len(play(played, Plan(data, "val_seen", ("hi",), 1, 224))) == 1
    weights.unlink()
    assert train.main([*command, "--validate-episodes", "0"]) == 0
    again = read_weights(weights).network
    assert all(torch.equal(*both) for both in zip(first.network.parameters(), again.parameters(), strict=True))
    assert train.main([*command, "--seed", "2"]) == 1
    assert train.main([*command, "--share", "0.5"]) == 1


def test_smoke_of_the_map_agent(data: Path, tmp_path: Path) -> None:
    """Its training goes on from its saved state with the same outcome, and refuses options of other agents."""
    folders = ["--data", str(data), "--output", str(tmp_path / "out")]
    command = ["--agent", "vl_map", "--smoke", *folders]
    assert train.main(command) == 0
    weights = tmp_path / "out" / "vl_map.safetensors"
    first, about = read_policy(weights)
    assert set(about["validation"]) == {"split", "episodes", "nDTW", "CTC-3", "PTC"}
    assert "python -m agents.train --agent vl_map --lang en,hi" in weights.with_suffix(".md").read_text()
    played = load_agent("agents.vl_map", {"weights": str(weights)})
    assert len(play(played, Plan(data, "val_seen", ("hi",), 1, 224))) == 1
    for lost in (
        (),
        ("vl_map.state-again.safetensors",),
        ("vl_map.state.safetensors", "vl_map.state-again.safetensors", "vl_map.walks-1.safetensors"),
    ):
        for name in lost:
            (tmp_path / "out" / name).unlink()
        weights.unlink()
        assert train.main([*command, "--validate-episodes", "0"]) == 0
        again, _ = read_policy(weights)
        assert all(torch.equal(one, two) for one, two in zip(first.parameters(), again.parameters(), strict=True))


@pytest.mark.parametrize(
    ("option", "message"),
    [
        (("--encoder", "pooled"), "vl_map has no option --encoder"),
        (("--lang", "fr"), "the split 'train' has no language 'fr'; it has en, hi"),
        (("--data", "nowhere"), "cannot be read"),
    ],
)
def test_what_the_map_agent_cannot_be_trained_by(
    option: tuple[str, ...], message: str, data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folders = ["--data", str(data), "--output", str(tmp_path)]
    assert train.main(["--agent", "vl_map", "--smoke", *folders, *option]) == 1
    assert message in capsys.readouterr().err


def test_walks_of_another_recipe_are_refused(data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = [
        "--agent",
        "vl_map",
        "--smoke",
        "--validate-episodes",
        "0",
        "--data",
        str(data),
        "--output",
        str(tmp_path),
    ]
    assert train.main(command) == 0
    assert train.main([*command, "--seed", "2"]) == 1
    assert "follows from another recipe or other data" in capsys.readouterr().err


def test_what_is_wrong_is_told(data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        train.main(["--agent", "vl_map_of_mine"])
    assert "there is no recipe 'vl_map_of_mine'; there are vl, " in capsys.readouterr().err
    folders = ["--data", str(data), "--cache", str(tmp_path), "--output", str(tmp_path)]
    assert train.main(["--agent", "vl", "--smoke", "--encoder", "pooled", "--lang", "fr", *folders]) == 1
    assert "has no language 'fr'; it has en, hi" in capsys.readouterr().err
