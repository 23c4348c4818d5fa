"""Training loop shared by all networks: updates, averaged weights, validation, checkpoints, TensorBoard log."""

import math
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple, Protocol

import torch
from tensorboardX import SummaryWriter
from torch import Tensor, nn

from arramon_agents.training.checkpoint import (
    TrainingCheckpoint,
    TrainingInputs,
    checkpoint_path,
    find_checkpoint,
    read_checkpoint,
    write_checkpoint,
)
from arramon_agents.training.schedule import Schedule
from arramon_agents.training.workspace import CHECKPOINT_STEPS, Report

Scores = Mapping[str, float]
"""Scores of a validation by metric."""

LOG_SECONDS = 1
"""Seconds until logged values are on disk. A resumed training does not log the updates before its checkpoint again."""

AVERAGE_WARM_UP = 10.0
"""The running average of the weights starts fast: update n keeps at most n / (n + AVERAGE_WARM_UP) of it."""


class Loss(NamedTuple):
    """Loss of one step.

    Attributes:
        total: scalar to minimise.
        parts: further scalars for the log, by name.
    """

    total: Tensor
    parts: Mapping[str, Tensor] = MappingProxyType({})


class TrainingTask(Protocol):
    """Interface of a training task: a network, and its loss on a batch of data."""

    @property
    def network(self) -> nn.Module:
        """Network to train."""
        ...

    def loss(self, step: int) -> Loss:
        """Return the loss on the batch of a step; the step's number determines the batch."""
        ...


@dataclass(frozen=True)
class TrainerSettings:
    """Settings of a training loop.

    Attributes:
        name: name of checkpoint and log.
        steps: total number of updates.
        rate: learning-rate schedule.
        seed: seed of dropout; tasks have seeds of their own.
        decay: weight decay of AdamW.
        clip: maximum gradient norm.
        average: decay of the running average of the weights; 0 for no average. It does not affect updates.
        validate_steps: updates between two validations.
        checkpoint_steps: updates between two checkpoints.
        chosen_by: metric that selects the best weights of a part of the network, by the prefix of its tensor names.
            The weights of other parts are those of the last update.
        training_inputs: recipe and data, which must match to resume from a checkpoint.
    """

    name: str
    steps: int
    rate: Schedule
    seed: int
    decay: float = 0.0
    clip: float = 5.0
    average: float = 0.0
    validate_steps: int = 1000
    checkpoint_steps: int = CHECKPOINT_STEPS
    chosen_by: Mapping[str, str] = field(default_factory=dict)
    training_inputs: TrainingInputs = field(default_factory=lambda: TrainingInputs({}, ""))


class Trainer:
    """Trains the network of a task, and resumes exactly from a checkpoint.

    Args:
        task: network, data and loss.
        settings: settings of the loop.
        output: folder of checkpoint and log; None to write neither.
        report: receives lines of progress.
        validate: returns scores of the network, which is in evaluation mode with the averaged weights; None for no
            validation.
        keep: called after each validation, for example to write the best weights.

    Attributes:
        step: number of updates so far.
        losses: loss of every update so far.
        cpu_seconds: processor time of updates and validations.
        scores: best score so far of each metric by which weights are chosen.
    """

    def __init__(
        self,
        task: TrainingTask,
        settings: TrainerSettings,
        output: Path | None = None,
        report: Report = lambda _: None,
        validate: Callable[[], Scores] | None = None,
        keep: Callable[[], object] = lambda: None,
    ) -> None:
        self.task, self.settings, self._output, self._report = task, settings, output, report
        self._validate, self._keep = validate, keep
        self.network = task.network
        self._optimizer = torch.optim.AdamW(self.network.parameters(), weight_decay=settings.decay)
        self.step, self.losses, self.cpu_seconds = 0, list[float](), 0.0
        self.scores: dict[str, float] = {}
        weights = self.network.state_dict() if settings.average else {}
        self._average = {name: value.clone() for name, value in weights.items()}
        self._best: dict[str, Tensor] = {}

    def run(self, until: int | None = None) -> None:
        """Train up to a step, resuming from a checkpoint if there is one.

        Args:
            until: number of updates to stop at; None for all.

        Raises:
            CheckpointMismatch: if the checkpoint belongs to another recipe, other data, or another version.
            BadWeights: if it cannot be read.
        """
        end = self.settings.steps if until is None else until
        if not self.step:
            self.resume()
        if self.step >= end:
            return
        first, began = self.step, time.monotonic()
        with self._open_log() as log:
            while self.step < end:
                for name, value in self._advance().items():
                    log.add_scalar(name, value, self.step)
                if self.step % self.settings.checkpoint_steps == 0 or self.step == end:
                    self.save()
                    left = (time.monotonic() - began) / (self.step - first) * (self.settings.steps - self.step)
                    self._report_progress(left)

    def update(self, rate: float | None = None) -> dict[str, float]:
        """Do one update, and return its losses by name, including "total".

        Args:
            rate: learning rate; None to use the schedule.
        """
        settings, network = self.settings, self.network.train()
        torch.manual_seed(settings.seed * 1_000_003 + self.step)  # The same dropout after resuming.
        for group in self._optimizer.param_groups:
            group["lr"] = settings.rate(self.step) if rate is None else rate
        loss = self.task.loss(self.step)
        self._optimizer.zero_grad()
        loss.total.backward()  # type: ignore[no-untyped-call]
        torch.nn.utils.clip_grad_norm_(network.parameters(), settings.clip)
        self._optimizer.step()
        self.step += 1
        self._update_average()
        self.losses.append(loss.total.item())
        return {"total": self.losses[-1]} | {name: part.item() for name, part in loss.parts.items()}

    def validate(self) -> Scores:
        """Validate, keep the weights of each part with a new best score, and return the scores."""
        if self._validate is None:
            return {}
        with self._averaged_network() as network:
            scores = self._validate()
            for prefix, metric in self.settings.chosen_by.items():
                if metric in scores and scores[metric] > self.scores.get(metric, -math.inf):
                    self.scores[metric] = scores[metric]
                    part = {name: value for name, value in network.state_dict().items() if name.startswith(prefix)}
                    self._best |= {name: value.detach().cpu().clone() for name, value in part.items()}
        self._keep()
        return scores

    def weights(self) -> dict[str, Tensor]:
        """Return the resulting weights so far, on the CPU.

        They are the best weights of parts that a metric selects, and the averaged weights (the last ones if there is no
        average) of all others.
        """
        last = self._average or self.network.state_dict()
        return {name: value.detach().cpu() for name, value in last.items()} | self._best

    def save(self) -> None:
        """Write a checkpoint."""
        if self._output is None:
            return
        optimizer = {
            f"{key}.{name}": value
            for name, parameter in self.network.named_parameters()
            for key, value in self._optimizer.state.get(parameter, {}).items()
        }
        tensors = {
            "network": dict(self.network.state_dict()),
            "optimizer": optimizer,
            "average": self._average,
            "best": self._best,
            "history": {"losses": torch.tensor(self.losses, dtype=torch.float64)},
        }
        checkpoint = TrainingCheckpoint(self.step, self.cpu_seconds, self.scores, tensors)
        write_checkpoint(checkpoint_path(self._output, self.settings.name), checkpoint, self.settings.training_inputs)

    def resume(self) -> None:
        """Resume from the checkpoint, if there is one.

        Raises:
            CheckpointMismatch: if it belongs to another recipe, other data, or another version.
            BadWeights: if it cannot be read.
        """
        path = None if self._output is None else find_checkpoint(self._output, self.settings.name)
        if path is None:
            return
        checkpoint = read_checkpoint(path, self.settings.training_inputs)
        tensors = checkpoint.tensors
        self.network.load_state_dict(tensors["network"])
        for name, value in self._average.items():
            value.copy_(tensors["average"][name])
        parameters = dict(self.network.named_parameters())
        for name, value in tensors["optimizer"].items():
            key, _, parameter = name.partition(".")
            device = "cpu" if key == "step" else parameters[parameter].device
            self._optimizer.state[parameters[parameter]][key] = value.to(device)
        self.step, self.cpu_seconds, self.scores = checkpoint.step, checkpoint.cpu_seconds, checkpoint.scores
        self.losses, self._best = tensors["history"]["losses"].tolist(), tensors["best"]
        self._report(f"{self.settings.name}: resumes at step {self.step} of {self.settings.steps}")

    def _advance(self) -> dict[str, float]:
        """Do one update, validate if it is due, and return scalars for the log."""
        began = time.process_time()
        scalars = {f"loss/{name}": value for name, value in self.update().items()}
        if self.step % self.settings.validate_steps == 0 or self.step == self.settings.steps:
            scalars |= {f"validation/{name}": value for name, value in self.validate().items()}
        self.cpu_seconds += time.process_time() - began
        return scalars

    def _update_average(self) -> None:
        kept = min(self.settings.average, self.step / (self.step + AVERAGE_WARM_UP))
        weights = self.network.state_dict() if self._average else {}
        for name, value in weights.items():
            if value.is_floating_point():
                self._average[name].lerp_(value, 1.0 - kept)
            else:
                self._average[name].copy_(value)

    @contextmanager
    def _averaged_network(self) -> Iterator[nn.Module]:
        """Yield the network in evaluation mode with the averaged weights, then restore its weights."""
        own = {name: value.clone() for name, value in self.network.state_dict().items()}
        self.network.load_state_dict(self._average or own)
        try:
            yield self.network.eval()
        finally:
            self.network.load_state_dict(own)

    def _open_log(self) -> SummaryWriter:
        if self._output is None:
            return SummaryWriter(write_to_disk=False)
        folder = self._output / "log" / self.settings.name
        return SummaryWriter(str(folder), purge_step=self.step, flush_secs=LOG_SECONDS)

    def _report_progress(self, seconds_left: float) -> None:
        recent = self.losses[-self.settings.checkpoint_steps :]
        self._report(
            f"{self.settings.name}: step {self.step} of {self.settings.steps}, loss {sum(recent) / len(recent):.3f}, "
            f"{seconds_left / 60:.0f} minutes left"
        )
