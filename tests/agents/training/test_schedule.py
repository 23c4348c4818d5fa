"""Learning-rate schedules: warm-up and decay."""

import pytest
import torch

from arramon_agents.training.schedule import constant, cosine, warm_up_cosine


def test_a_constant_rate() -> None:
    assert [constant(0.1)(step) for step in (0, 7)] == [0.1, 0.1]


def test_the_rate_rises_and_falls() -> None:
    rate = warm_up_cosine(0.01, 100)
    rates = [rate(step) for step in range(100)]
    assert rates[:4] == pytest.approx([0.002, 0.004, 0.006, 0.008])
    assert rates.index(max(rates)) == 4
    assert max(rates) == pytest.approx(0.01)
    assert rates[4:] == sorted(rates[4:], reverse=True)
    assert rates[-1] == pytest.approx(0.0001)


@pytest.mark.parametrize("steps", [1, 2, 9])
def test_the_cosine_is_that_of_torch(steps: int) -> None:
    optimizer = torch.optim.SGD([torch.nn.Parameter(torch.zeros(1))], 0.03)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimizer, steps)
    rate = cosine(0.03, steps)
    for step in range(steps):
        assert rate(step) == schedule.get_last_lr()[0]
        optimizer.step()
        schedule.step()
