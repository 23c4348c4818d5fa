"""The command that trains: a smoke test for each agent that comes along, from episodes to a run with its weights."""

from pathlib import Path

import pytest

from agents import train
from agents.learning.checkpoint import load_policy
from agents.learning.recipe import RECIPES
from agents.learning.rollouts import Plan, play
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


def test_what_is_wrong_is_told(data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        train.main(["--agent", "vl_map_of_mine"])
    assert "there is no recipe 'vl_map_of_mine'; there are vl, " in capsys.readouterr().err
    folders = ["--data", str(data), "--cache", str(tmp_path), "--output", str(tmp_path)]
    assert train.main(["--agent", "vl", "--smoke", "--encoder", "pooled", "--lang", "fr", *folders]) == 1
    assert "has no language 'fr'; it has en, hi" in capsys.readouterr().err
