"""The agent with trained weights: batched play equals single play, and errors name what is missing."""

from pathlib import Path

import numpy as np
import pytest
import torch

from arramon_agents import requirements
from arramon_agents.perception.registry import open_encoder
from arramon_agents.reading.tokenizers import PolicyWordTokenizer
from arramon_agents.training.rollouts import RolloutPlan, play
from arramon_agents.vl import make_agent
from arramon_agents.vl.agent import LearnedAgent
from arramon_agents.vl.config import ModelConfig
from arramon_agents.vl.model import Model
from arramon_agents.vl.policy import VlPolicy, load_policy, save_policy
from arramon_agents.weights import BadWeights, find_weights, write_tensors
from arramon_client import AgentLoadError, Episode, Observation, load_agent


def policy(*, sees: bool = True, reads: bool = True) -> VlPolicy:
    torch.manual_seed(1)
    encoder = open_encoder("pooled") if sees else None
    tokenizer = PolicyWordTokenizer.train(["go left", "बाएँ जाएँ", "put it there"], least=1)
    channels = encoder.channels if encoder else 0
    config = ModelConfig(tokenizer.size, channels, sees, reads, positions=True, word_size=8, action_size=4, hidden=16)
    return VlPolicy(Model(config).eval(), tokenizer, encoder, {"seed": 1})


def observation(episode_id: str, step: int, phase: str = "navigation", text: str = "go left") -> Observation:
    random = np.random.default_rng([int(episode_id), step])
    rgb = random.integers(0, 256, (224, 224, 3), np.uint8)
    depth = random.uniform(0, 20, (224, 224)).astype(np.float32)
    return Observation(episode_id, 1, phase, step, text, step, 150 - step, rgb, depth)


def playing(*, temperature: float = 0.0) -> LearnedAgent:
    agent = LearnedAgent(policy(), "vl", temperature=temperature)
    for episode_id in "123":
        agent.begin(Episode(episode_id, "en", "val_seen"))
    return agent


@pytest.mark.parametrize("temperature", [0.0, 1.0])
def test_episodes_do_not_touch_each_other(temperature: float) -> None:
    texts = {"1": "go left", "2": "बाएँ जाएँ go go go", "3": "put it there"}
    phases = {"1": "navigation", "2": "navigation", "3": "assembly"}
    together, alone = playing(temperature=temperature), playing(temperature=temperature)
    for step in range(6):
        seen = [observation(each, step, phases[each], texts[each]) for each in "123"]
        assert together.act(seen) == [alone.act([each])[0] for each in seen]


def test_an_episode_that_begins_again_is_forgotten() -> None:
    agent = playing()
    first = [agent.act([observation("1", step)]) for step in range(5)]
    agent.begin(Episode("1", "en", "val_seen"))
    assert [agent.act([observation("1", step)]) for step in range(5)] == first


def test_draws_differ_by_seed_only() -> None:
    def drawn(seed: int) -> list[int]:
        agent = LearnedAgent(policy(), "vl", seed=seed, temperature=5.0)
        agent.begin(Episode("1", "en", "val_seen"))
        return [agent.act([observation("1", step)])[0] for step in range(20)]

    assert drawn(1) == drawn(1)
    assert drawn(1) != drawn(2)


def test_without_images_it_says_what_is_missing() -> None:
    blind = Observation("1", 1, "navigation", 0, "go", 0, 150)
    with pytest.raises(ValueError, match="the observation has no rgb, which the agent needs"):
        playing().act([blind])


def test_an_agent_that_sees_nothing_asks_for_no_images() -> None:
    agent = LearnedAgent(policy(sees=False), "language_only")
    agent.begin(Episode("1", "en", "val_seen"))
    assert agent.sensors == ()
    assert agent.act([Observation("1", 1, "navigation", 0, "go left", 0, 150)])[0] in range(4)


@pytest.mark.parametrize(("sees", "reads"), [(True, True), (True, False), (False, True)])
def test_weights_come_back_as_they_were(tmp_path: Path, sees: bool, reads: bool) -> None:
    made = policy(sees=sees, reads=reads)
    save_policy(made, tmp_path / "w.safetensors")
    again = load_policy(find_weights(str(tmp_path / "w.safetensors")))
    assert again.model.config == made.model.config
    assert again.about == {"seed": 1}
    seen = [observation("1", 0), observation("2", 0)]
    first, second = LearnedAgent(made, "a"), LearnedAgent(again, "a")
    assert first.act(seen) == second.act(seen)
    for name, value in made.model.state_dict().items():
        assert torch.equal(value, again.model.state_dict()[name])


@pytest.mark.parametrize(("given", "expected"), [(None, 5.0), (0.0, 0.0)])
def test_it_plays_at_the_temperature_of_its_recipe(tmp_path: Path, given: float | None, expected: float) -> None:
    made = policy()
    made.about["recipe"] = {"temperature": 5.0}
    save_policy(made, tmp_path / "w")
    agents = [
        make_agent(str(tmp_path / "w"), temperature=given),
        LearnedAgent(made, "vl", temperature=expected),
        LearnedAgent(made, "vl", temperature=5.0 - expected),
    ]
    for agent in agents:
        agent.begin(Episode("1", "en", "val_seen"))
    seen = [observation("1", step) for step in range(20)]
    played, same, other = ([agent.act([each])[0] for each in seen] for agent in agents)
    assert played == same != other


def test_bad_weights_are_told(tmp_path: Path) -> None:
    (tmp_path / "text").write_text("no weights")
    write_tensors(tmp_path / "other", {"tokenizer": torch.zeros(1, dtype=torch.uint8)}, {"format": 0})
    with pytest.raises(BadWeights, match="is no file of weights"):
        load_policy(tmp_path / "text")
    with pytest.raises(BadWeights, match="has the format 0, expected 1"):
        load_policy(tmp_path / "other")
    with pytest.raises(AgentLoadError, match="there are no weights 'nowhere'"):
        load_agent("agents.vl", {"weights": "nowhere"})


def test_weights_of_another_encoder_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    save_policy(policy(), tmp_path / "w")
    monkeypatch.setattr("arramon_agents.perception.pooled.PooledEncoder.fingerprint", "pooled-0")
    with pytest.raises(BadWeights, match="trained on the visual encoder pooled pooled-1, but pooled-0 is installed"):
        load_policy(tmp_path / "w")


def test_without_the_extra_the_command_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(requirements, "find_spec", lambda name: None if name == "torch" else object())
    with pytest.raises(AgentLoadError, match=r"agents.vl needs torch: install the extra with `scripts/setup`"):
        load_agent("agents.vl")


def test_rollouts_score_every_episode(data: Path) -> None:
    ended: list[str] = []

    class Ending(LearnedAgent):
        def end(self, episode_id: str) -> None:
            super().end(episode_id)
            ended.append(episode_id)

    scores = play(Ending(policy(), "vl"), RolloutPlan(data, "train", ("en",), 0, 112))
    assert sorted(scores) == sorted(ended)
    assert sorted(scores) == ["0", "1", "2", "3", "4", "5"]
    assert all(0 <= each["nDTW"] <= 1 for each in scores.values())
    right = play(LearnedAgent(policy(), "vl"), RolloutPlan(data, "train", ("en", "hi"), 3, 112, phases=("assembly",)))
    assert [each["CTC-3"] for each in right.values()] == [1.0, 1.0, 1.0]
