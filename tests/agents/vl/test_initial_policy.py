"""Initial policy of a training: fine-tuning keeps weights, adds words, and rejects other models."""

from dataclasses import replace
from pathlib import Path

import pytest
import torch

from arramon_agents.reading.tokenizers import SPECIAL, UNKNOWN, PolicyWordTokenizer
from arramon_agents.vl.initial_policy import initial_policy
from arramon_agents.vl.policy import load_policy, save_policy
from arramon_agents.vl.train import Imitation
from arramon_client.world import PHASES
from tests.agents.training_fixtures import demonstrations, place, recipe

NEW = ["veer left", "veer right", "once"]
"""Texts with one word that is new and occurs twice; "once" is not added."""


@pytest.fixture
def weights(tmp_path: Path) -> Path:
    path = tmp_path / "vl.safetensors"
    save_policy(Imitation(recipe(), place(tmp_path), demonstrations()).policy, path)
    return path


@pytest.mark.parametrize("is_folder", [True, False])
def test_words_are_added_and_begin_as_unknown_ones(is_folder: bool, weights: Path, tmp_path: Path) -> None:
    known = load_policy(weights)
    init = replace(recipe(), init=str(weights.parent if is_folder else weights))
    policy = initial_policy(init, NEW, place(tmp_path), print)
    assert isinstance(known.tokenizer, PolicyWordTokenizer)
    assert isinstance(policy.tokenizer, PolicyWordTokenizer)
    assert policy.tokenizer.vocabulary == (*known.tokenizer.vocabulary, "veer")
    assert policy.tokenizer.encode("veer once")[1] == UNKNOWN
    state = known.model.state_dict()
    for name, value in policy.model.state_dict().items():
        if name.endswith("reader.embedding.weight"):
            assert torch.equal(value[-1], state[name][UNKNOWN])
            value = value[: known.tokenizer.size]
        assert torch.equal(value, state[name]), name
    assert policy.model.config.vocabulary == len(policy.tokenizer.vocabulary) + SPECIAL
    text = "left right"
    for phase in PHASES:
        both = [
            each.model.eval().of(phase).read(torch.tensor([each.tokenizer.encode(text)])) for each in (known, policy)
        ]
        assert torch.equal(both[0].words, both[1].words)


def test_fine_tuning_learns_and_says_where_it_began(weights: Path, tmp_path: Path) -> None:
    tuned = replace(recipe(passes=40), init=str(weights), split="people", every=2)
    made = Imitation(tuned, place(tmp_path / "tuned"), demonstrations())
    made.run()
    assert sum(made.trainer.losses[-5:]) < sum(made.trainer.losses[:5]) / 3
    card = made.weights.with_suffix(".md").read_text()
    assert f"--every 2 --init {weights}" in card
    assert "6 episodes of `people`" in card
    assert "at last on the texts of `people` alone" in card
    assert "generated episodes alone" not in card


def test_weights_of_another_model_are_refused(weights: Path, tmp_path: Path) -> None:
    for other in (recipe(sees=False), replace(recipe(), tokenizer="sentencepiece")):
        with pytest.raises(ValueError, match="is of another model than the recipe"):
            initial_policy(replace(other, init=str(weights)), NEW, place(tmp_path), print)


def test_a_number_of_episodes_below_one_is_refused() -> None:
    with pytest.raises(ValueError, match="every 0th episode: expected 1 or more"):
        replace(recipe(), every=0)
