"""Training loop: exact resuming, averaged weights, selection of the best weights by validation."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
import torch
from torch import nn

from arramon_agents.training.checkpoint import CheckpointMismatch, TrainingInputs, checkpoint_path
from arramon_agents.training.schedule import warm_up_cosine
from arramon_agents.training.trainer import Loss, Scores, Trainer, TrainerSettings

SETTINGS = TrainerSettings(
    "line",
    steps=16,
    rate=warm_up_cosine(0.01, 16),
    seed=3,
    decay=0.01,
    checkpoint_steps=4,
    training_inputs=TrainingInputs({"rate": 0.01}, "data"),
)


class Line:
    """A task with dropout, whose batches follow from their steps."""

    def __init__(self) -> None:
        torch.manual_seed(5)
        self.network = nn.Sequential(nn.Linear(3, 8), nn.ReLU(), nn.Dropout(0.3), nn.Linear(8, 1))

    def loss(self, step: int) -> Loss:
        inputs = torch.stack([torch.sin(torch.arange(3) * (number + 1.0)) for number in range(4 * step, 4 * step + 4)])
        loss = (self.network(inputs)[:, 0] - inputs.sum(1)).square().mean()
        return Loss(loss, {"halved": loss / 2.0})


def weights(trainer: Trainer) -> list[list[float]]:
    return [value.flatten().tolist() for value in trainer.weights().values()]


@pytest.mark.parametrize("average", [0.0, 0.8])
@pytest.mark.parametrize("until", [4, 7])
def test_a_resumed_training_is_as_if_it_had_not_been_interrupted(average: float, until: int, tmp_path: Path) -> None:
    settings = replace(SETTINGS, average=average)
    whole = Trainer(Line(), settings, tmp_path / "whole")
    whole.run()
    Trainer(Line(), settings, tmp_path / "parts").run(until)
    torch.manual_seed(99)
    resumed = Trainer(Line(), settings, tmp_path / "parts")
    resumed.run()
    assert resumed.losses == whole.losses
    assert weights(resumed) == weights(whole)
    files = [checkpoint_path(tmp_path / name, "line").read_bytes() for name in ("whole", "parts")]
    tensors = [file[8 + int.from_bytes(file[:8], "little") :] for file in files]
    assert tensors[0] == tensors[1]


def test_updates_after_the_last_checkpoint_are_done_again(tmp_path: Path) -> None:
    whole = Trainer(Line(), SETTINGS, tmp_path / "whole")
    whole.run()
    killed = Trainer(Line(), SETTINGS, tmp_path / "killed")
    killed.run(4)
    killed.update()
    resumed = Trainer(Line(), SETTINGS, tmp_path / "killed")
    resumed.run(0)
    assert resumed.step == 4
    resumed.run()
    assert resumed.losses == whole.losses


def test_a_finished_training_stays_as_it_is(tmp_path: Path) -> None:
    Trainer(Line(), SETTINGS, tmp_path).run()
    told: list[str] = []
    again = Trainer(Line(), SETTINGS, tmp_path, told.append)
    again.run()
    assert again.step == len(again.losses) == 16
    assert told == ["line: resumes at step 16 of 16"]


def test_without_a_folder_nothing_is_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    trainer = Trainer(Line(), SETTINGS)
    trainer.run()
    assert trainer.step == 16
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("training_inputs", "message"),
    [
        (
            TrainingInputs({"rate": 0.1}, "data"),
            r"another recipe \(rate 0.01, expected 0.1\): name another --output",
        ),
        (TrainingInputs({"rate": 0.01, "more": 1}, "data"), r"another recipe \(more None, expected 1\)"),
        (TrainingInputs({}, "data"), r"another recipe \(rate 0.01, expected None\)"),
        (TrainingInputs({"rate": 0.01}, "other"), "is of other data: name another --output, or remove it"),
    ],
)
def test_a_checkpoint_of_another_training_is_refused(
    training_inputs: TrainingInputs, message: str, tmp_path: Path
) -> None:
    Trainer(Line(), SETTINGS, tmp_path).run(4)
    with pytest.raises(CheckpointMismatch, match=message):
        Trainer(Line(), replace(SETTINGS, training_inputs=training_inputs), tmp_path).run()


def test_averaged_weights_change_no_update() -> None:
    plain, averaged = Trainer(Line(), SETTINGS), Trainer(Line(), replace(SETTINGS, average=0.8))
    expected = [value.clone() for value in averaged.network.state_dict().values()]
    for step in range(1, 16):
        assert plain.update() == averaged.update()
        kept = min(0.8, step / (step + 10.0))
        new = averaged.network.state_dict().values()
        expected = [kept * old + (1.0 - kept) * value for old, value in zip(expected, new, strict=True)]
    for value, wanted in zip(averaged.weights().values(), expected, strict=True):
        torch.testing.assert_close(value, wanted)
    assert weights(plain) == [value.flatten().tolist() for value in averaged.network.state_dict().values()]


def scored(values: list[tuple[float, float]]) -> Callable[[], Scores]:
    left = iter(values)
    return lambda: dict(zip(("a", "b"), next(left), strict=True))


def test_the_best_weights_of_each_part_are_kept(tmp_path: Path) -> None:
    """Of four validations the third is best for the first layer, the first for the last layer; they outlive a kill."""
    settings = replace(SETTINGS, validate_steps=4, chosen_by={"0.": "a", "3.": "b"})
    values = [(0.1, 0.5), (0.2, 0.4), (0.3, 0.5), (0.3, 0.2)]
    passed = []
    for number in range(4):  # A kill after each validation.
        trainer = Trainer(Line(), settings, tmp_path, validate=scored(values[number:]))
        trainer.run(4 * number + 4)
        passed.append({name: value.clone() for name, value in trainer.network.state_dict().items()})
    assert trainer.scores == {"a": 0.3, "b": 0.5}
    for name, value in trainer.weights().items():
        assert torch.equal(value, passed[2 if name.startswith("0.") else 0][name]), name


def test_averaged_weights_are_validated_in_evaluation_mode() -> None:
    settings = replace(SETTINGS, average=0.9, validate_steps=5)
    task, seen = Line(), list[bool]()

    def validate() -> Scores:
        own = task.network.state_dict()
        seen.append(not task.network.training and all(torch.equal(own[name], value) for name, value in last.items()))
        return {}

    trainer = Trainer(task, settings, validate=validate)
    for _ in range(5):
        trainer.update()
    last, before = trainer.weights(), {name: value.clone() for name, value in task.network.state_dict().items()}
    trainer.validate()
    assert seen == [True]
    assert all(torch.equal(task.network.state_dict()[name], value) for name, value in before.items())
    assert not all(torch.equal(last[name], value) for name, value in before.items())


def test_losses_and_scores_are_logged(tmp_path: Path) -> None:
    told: list[str] = []
    Trainer(Line(), replace(SETTINGS, validate_steps=8), tmp_path, told.append, lambda: {"seen": 1.0}).run()
    (log,) = (tmp_path / "log" / "line").iterdir()
    written = log.read_bytes()
    for name in (b"loss/total", b"loss/halved", b"validation/seen"):
        assert name in written
    assert [line.split(",")[0] for line in told] == [f"line: step {step} of 16" for step in (4, 8, 12, 16)]
