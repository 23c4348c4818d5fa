"""Training targets and loss of the block network."""

import numpy as np
import pytest
import torch

from arramon_agents.perception.eyes.network import EyesNetwork, EyesSizes
from arramon_agents.perception.eyes.targets import LabelTable, loss_of
from arramon_agents.perception.eyes.vocabulary import NONE, codes_of

LABELS = [("road", "", ""), ("cone", "red", ""), ("mug", "blue", "dotted"), ("building", "", "glass")]


@pytest.mark.parametrize(
    ("pixels", "expected"),
    [
        ({}, 0),
        ({3: 64}, 3),
        ({1: 3}, 1),
        ({1: 2}, 0),  # Less than a twenty-fifth of a block.
        ({1: 40, 2: 3}, 2),
        ({1: 40, 2: 2}, 1),
        ({3: 60, 2: 4}, 2),
    ],
)
def test_a_block_shows_the_rarest_of_what_covers_enough_of_it(pixels: dict[int, int], expected: int) -> None:
    labels = np.zeros((224, 224), np.uint16)
    block = np.zeros(64, np.uint16)
    first = 0
    for label, count in pixels.items():
        block[first : first + count] = label
        first += count
    labels[8:16, 16:24] = block.reshape(8, 8)
    targets = LabelTable(LABELS).blocks(labels)
    assert targets.shape == (3, 28, 28)
    assert tuple(targets[:, 1, 2]) == codes_of(*LABELS[expected])
    assert tuple(targets[:, 1, 3]) == codes_of(*LABELS[0]) == (1, NONE, NONE)


def test_the_loss_falls_when_it_is_minimised() -> None:
    torch.manual_seed(0)
    network = EyesNetwork(EyesSizes(56, 8, 16, 16))
    images = torch.rand(2, 6, 56, 56)
    labels = np.random.default_rng(0).integers(0, 4, (2, 56, 56)).astype(np.uint16)
    targets = torch.from_numpy(np.stack([LabelTable(LABELS).blocks(each) for each in labels]))
    optimiser = torch.optim.Adam(network.parameters(), 0.01)
    losses = []
    for _ in range(8):
        loss = loss_of(network(images), targets)
        optimiser.zero_grad()
        loss.backward()  # type: ignore[no-untyped-call]
        optimiser.step()
        losses.append(float(loss.detach()))
    assert losses[-1] < 0.7 * losses[0]
