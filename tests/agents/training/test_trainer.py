"""Training: resumed as if it had not been interrupted."""

from pathlib import Path

import pytest
import torch
from torch import Tensor, nn

from arramon_agents.training.run import train
from arramon_agents.training.trainer import Plan, Trainer

PLAN = Plan(samples=64, batch=4, rate=0.01)


class Line:
    """A task with dropout, whose samples follow from their numbers."""

    def __init__(self) -> None:
        self.network = nn.Sequential(nn.Linear(3, 8), nn.ReLU(), nn.Dropout(0.3), nn.Linear(8, 1))

    def loss(self, numbers: range) -> Tensor:
        inputs = torch.stack([torch.sin(torch.arange(3) * (number + 1.0)) for number in numbers])
        loss: Tensor = (self.network(inputs)[:, 0] - inputs.sum(1)).square().mean()
        return loss


def losses(trainer: Trainer, steps: int) -> list[float]:
    return [trainer.step() for _ in range(steps)]


def test_a_resumed_training_has_the_same_losses(tmp_path: Path) -> None:
    undisturbed = losses(Trainer(PLAN, Line), 12)
    first = Trainer(PLAN, Line)
    before = losses(first, 5)
    first.save(tmp_path / "state.safetensors")
    second = Trainer(PLAN, Line)
    second.restore(tmp_path / "state.safetensors")
    assert before + losses(second, 7) == undisturbed


def test_a_state_of_another_plan_is_refused(tmp_path: Path) -> None:
    trainer = Trainer(PLAN, Line)
    trainer.step()
    trainer.save(tmp_path / "state.safetensors")
    with pytest.raises(ValueError, match="another plan"):
        Trainer(Plan(samples=128, batch=4, rate=0.01), Line).restore(tmp_path / "state.safetensors")


def test_the_rate_rises_and_falls() -> None:
    rates = [PLAN.rate_at(step) for step in range(PLAN.steps)]
    assert rates.index(max(rates)) < 3
    assert rates[-1] < 0.02 * max(rates)


def test_a_run_is_logged_and_goes_on_from_its_state(tmp_path: Path) -> None:
    train(Trainer(PLAN, Line), tmp_path, "line", lambda: {"seen": 1})
    lines = (tmp_path / "line.log.jsonl").read_text().splitlines()
    assert '"step": 16' in lines[-1]
    assert '"seen": 1' in lines[-1]
    again = Trainer(PLAN, Line)
    train(again, tmp_path, "line")
    assert again.done == PLAN.steps
    assert (tmp_path / "line.log.jsonl").read_text().splitlines() == lines
