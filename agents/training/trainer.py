"""Training loop of a network with a learning rate schedule, exactly resumable from any saved state."""

import json
import logging
import math
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Protocol

import torch
from safetensors import safe_open
from safetensors.torch import save_file
from torch import Tensor, nn

LOG = logging.getLogger(__name__)

MOMENTS = ("exp_avg", "exp_avg_sq")
"""The optimiser's state of each parameter."""


@dataclass(frozen=True, slots=True)
class Plan:
    """Settings of a training.

    Attributes:
        samples: total number of samples.
        batch: samples of a step.
        rate: the highest learning rate, after the warm-up; it falls to nearly 0 at the end.
        warm_up: share of the steps in which the rate rises.
        decay: of weights.
        seed: of the initial weights. Samples have seeds of their own.
        about: other settings that must match to resume from a saved state, such as the size of the frames.
    """

    samples: int
    batch: int
    rate: float
    warm_up: float = 0.05
    decay: float = 0.0001
    seed: int = 0
    about: str = ""

    @property
    def steps(self) -> int:
        """Number of steps."""
        return self.samples // self.batch

    def rate_at(self, step: int) -> float:
        """Return the learning rate of a step."""
        done = (step + 1) / self.steps
        if done < self.warm_up:
            return self.rate * done / self.warm_up
        return self.rate * (0.01 + 0.99 * 0.5 * (1.0 + math.cos(math.pi * (done - self.warm_up) / (1 - self.warm_up))))


class Task(Protocol):
    """A network, and its loss on a batch of samples given by their numbers."""

    @property
    def network(self) -> nn.Module:
        """The network to be trained."""
        ...

    def loss(self, numbers: range) -> Tensor:
        """Return a scalar."""
        ...


class Trainer:
    """Trains a network; its state is saved and restored exactly.

    Args:
        plan: how it is trained.
        make_task: returns the task with its initial weights; called once, with torch seeded.
    """

    def __init__(self, plan: Plan, make_task: Callable[[], Task]) -> None:
        torch.manual_seed(plan.seed)
        self.plan, self._task = plan, make_task()
        self.network = self._task.network
        self._optimiser = torch.optim.AdamW(self.network.parameters(), plan.rate, weight_decay=plan.decay)
        self.done = 0
        self.seconds = 0.0

    def step(self) -> float:
        """Train on the next batch; return its loss."""
        began = time.thread_time()
        torch.manual_seed(self.plan.seed * 1_000_003 + self.done)  # Of dropout: the same when training goes on.
        self.network.train()
        for group in self._optimiser.param_groups:
            group["lr"] = self.plan.rate_at(self.done)
        loss = self._task.loss(range(self.done * self.plan.batch, (self.done + 1) * self.plan.batch))
        self._optimiser.zero_grad()
        loss.backward()  # type: ignore[no-untyped-call]
        torch.nn.utils.clip_grad_norm_(self.network.parameters(), 5.0)
        self._optimiser.step()
        self.done += 1
        self.seconds += time.thread_time() - began
        return float(loss.detach())

    def save(self, path: Path) -> None:
        """Write the state from which training can resume."""
        tensors = {f"network.{name}": value.contiguous() for name, value in self.network.state_dict().items()}
        for name, parameter in self.network.named_parameters():
            state = self._optimiser.state.get(parameter, {})
            tensors |= {f"{moment}.{name}": state[moment].contiguous() for moment in MOMENTS if moment in state}
        about = {"done": str(self.done), "seconds": str(self.seconds), "plan": json.dumps(asdict(self.plan))}
        new = path.with_suffix(".new")
        save_file(tensors, new, about)
        new.replace(path)

    def restore(self, path: Path) -> None:
        """Resume from a saved state.

        Raises:
            ValueError: if the state is of another plan.
        """
        with safe_open(path, "pt") as file:
            about = file.metadata()
            if json.loads(about["plan"]) != json.loads(json.dumps(asdict(self.plan))):
                raise ValueError(f"{path} was trained by another plan: {about['plan']}")
            names = set(file.keys())
            trained = {name: file.get_tensor(f"network.{name}") for name in self.network.state_dict()}
            self.network.load_state_dict(trained)
            for name, parameter in self.network.named_parameters():
                if f"{MOMENTS[0]}.{name}" in names:
                    moments = {moment: file.get_tensor(f"{moment}.{name}") for moment in MOMENTS}
                    self._optimiser.state[parameter] = {"step": torch.tensor(float(about["done"])), **moments}
        self.done, self.seconds = int(about["done"]), float(about["seconds"])
