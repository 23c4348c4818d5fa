"""Batches: steps in the loss, and content of the tensors."""

import random
from dataclasses import replace

import numpy as np
import pytest
import torch

from arramon_agents.reading.tokenizers import PolicyWordTokenizer
from arramon_agents.training.batches import NO_ACTION
from arramon_agents.training.demonstrations import PhaseDemonstration
from arramon_agents.vl.batches import action_loss, make_batch, select_loss_steps
from arramon_agents.vl.model import START_ACTION

WALK = [0, 0, 0, 1, 1, 0, 0, 0, 0, 3]
"""Changes at steps 0, 3, 5 and 9."""


def demonstration(actions: list[int]) -> PhaseDemonstration:
    """Features tell the number of each step."""
    features = np.arange(len(actions), dtype=np.uint8)[:, None, None, None] + np.zeros((1, 7, 7, 2), np.uint8)
    return PhaseDemonstration("1", 1, "navigation", {"en": "go left"}, np.array(actions, np.uint8), features)


@pytest.mark.parametrize(("share", "expected"), [(0.0, [0, 3, 5, 9]), (1.0, list(range(10)))])
def test_changes_of_action_are_learned_from_and_a_share_of_the_rest(share: float, expected: list[int]) -> None:
    assert select_loss_steps(WALK, share, random.Random(1)) == expected


def test_the_share_is_that_of_the_repeated_actions() -> None:
    chance = random.Random(1)
    counts = [len(select_loss_steps([0] * 101, 0.3, chance)) - 1 for _ in range(50)]
    assert 28 < sum(counts) / 50 < 32
    assert len(set(counts)) > 3  # Drawn anew each time.


def test_tensors_hold_the_steps_that_are_learned_from() -> None:
    walks = [demonstration(WALK), demonstration([2, 2, 3])]
    batch = make_batch(walks, ["go left", "go"], PolicyWordTokenizer.train(["go left"], least=1), share=0.0)
    assert batch.loss_steps.tolist() == [[0, 3, 5, 9], [0, 2, 0, 0]]
    assert batch.actions.tolist() == [[0, 1, 0, 3], [2, 3, NO_ACTION, NO_ACTION]]
    assert (batch.cells[:, :, 3, 3, 0] * 255).round().tolist() == [[0, 3, 5, 9], [0, 2, 0, 0]]
    assert batch.previous_actions.tolist() == [[START_ACTION, *WALK[:-1]], [START_ACTION, 2, 2, *[START_ACTION] * 7]]
    assert (batch.tokens != 0).sum(1).tolist() == [2, 1]


def test_the_draw_follows_from_the_seed() -> None:
    tokenizer = PolicyWordTokenizer.train(["go left"], least=1)
    drawn = [make_batch([demonstration([0] * 40)], ["go"], tokenizer, 0.5, seed).loss_steps.tolist() for seed in "112"]
    assert drawn[0] == drawn[1] != drawn[2]


def test_padding_has_no_part_in_the_loss() -> None:
    batch = make_batch(
        [demonstration(WALK), demonstration([2, 2, 3])], ["go"] * 2, PolicyWordTokenizer.train(["go"], least=1), 0.0
    )
    values = torch.randn(2, 4, 5)
    loss = action_loss(values, batch)
    values[1, 2:] = 100.0 * torch.randn(2, 5)
    assert torch.equal(action_loss(values, batch), loss)


@pytest.mark.parametrize(("phase", "expected"), [("navigation", 0.0), ("assembly", 3.0)])
def test_the_pick_up_has_a_weight_of_its_own_in_the_streets(phase: str, expected: float) -> None:
    """All values say "forward"; with a weight of 0 only the right steps forward count."""
    demonstrated = replace(demonstration([0, 3]), phase=phase)
    batch = make_batch([demonstrated], ["go"], PolicyWordTokenizer.train(["go"], least=1))
    values = torch.zeros(1, 2, 5)
    values[..., 0] = 6.0
    usual = action_loss(values[:, :1], replace(batch, actions=batch.actions[:, :1])).item()
    assert action_loss(values, batch, 0.0).item() == pytest.approx(usual + expected, abs=1e-5)
