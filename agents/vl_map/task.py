"""Training tasks of `vl_map`: imitation of labelled decisions, with mirror images, and prediction of target cells."""

import math
from collections.abc import Sequence
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
import numpy.typing as npt
import torch
from safetensors import safe_open
from safetensors.numpy import save_file
from torch import Tensor
from torch.nn import functional

from arramon_agents.simulated.room_examples import RoomExample, with_naming_errors
from arramon_agents.simulated.walks import LabelledDecision
from arramon_agents.training.trainer import Loss
from arramon_agents.vl_map.features import PolicyInput, mirror
from arramon_agents.vl_map.network import PolicyNetwork, direction_bins, soft_bins, tensors_of
from arramon_agents.vl_map.options import DISTANCES, OPTIONS, WAYPOINTS
from arramon_agents.vl_map.placement_network import CELLS, PlacementNetwork, placement_input, stack_inputs

PROGRESS = 0.3
"""Weight of the auxiliary loss: predict the row that is being carried out."""

KEPT = {"rows": np.uint8, "match": np.float16}
"""Smaller types in which some arrays are stored."""

Arrays = dict[str, npt.NDArray[np.generic]]


def arrays_of(decided: Sequence[LabelledDecision]) -> Arrays:
    """Return labelled decisions as arrays, by name; labels are (n, 4)."""
    arrays: Arrays = {
        name: np.stack(part).astype(KEPT.get(name, part[0].dtype))
        for name, part in zip(PolicyInput._fields, zip(*(each.sample for each in decided), strict=True), strict=True)
    }
    arrays["label"] = np.array([each.label for each in decided], np.float32)
    return arrays


def save_arrays(path: Path, arrays: Arrays, about: str, seconds: float) -> None:
    """Write arrays to a file, atomically.

    Args:
        path: the file.
        arrays: arrays by name.
        about: settings that determine the arrays, as JSON.
        seconds: processor time spent on computing them.
    """
    new = path.with_suffix(".new")
    save_file(arrays, new, {"about": about, "seconds": str(seconds)})
    new.replace(path)


def load_arrays(path: Path, about: str) -> tuple[Arrays, float]:
    """Return the arrays of a file, and the processor time in seconds spent on computing them.

    Raises:
        ValueError: if they were computed with other settings.
    """
    with safe_open(path, "np") as file:
        metadata = file.metadata() or {}
        if metadata.get("about") != about:
            raise ValueError(
                f"{path} was made with another recipe or other data: {metadata.get('about')}; name another folder"
            )
        arrays = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118 - not a mapping
    return arrays, float(metadata["seconds"])


class DecisionTask:
    """Training task: predict the labels of decisions.

    Args:
        network: network to train.
        batch: number of decisions in a batch.
        seed: seed of the order of the decisions.
        precision: "float32" or "bfloat16".
        device: device of the network.
    """

    def __init__(
        self, network: PolicyNetwork, batch: int, seed: int, precision: str = "float32", device: str = "cpu"
    ) -> None:
        self.network, self._batch, self._seed, self._device = network, batch, seed, device
        self._type = getattr(torch, precision)
        self._arrays: Arrays = {}

    @property
    def count(self) -> int:
        """Number of training decisions."""
        return len(self._arrays["label"]) if self._arrays else 0

    def add(self, arrays: Arrays) -> None:
        """Add training decisions."""
        known = self._arrays
        self._arrays = {name: np.concatenate([known[name], new]) if known else new for name, new in arrays.items()}

    def loss(self, step: int) -> Loss:
        """Return the cross-entropy of a random batch of decisions; half of them are mirrored."""
        random = np.random.default_rng((self._seed, step * self._batch))
        chosen = random.integers(self.count, size=self._batch)
        half = self._batch // 2  # The batch is in random order: mirror its first half.
        parts: Any = mirror(self._samples(chosen[:half])), self._samples(chosen[half:])
        sample = PolicyInput(*(np.concatenate(part) for part in zip(*parts, strict=True)))
        labels = torch.tensor(self._arrays["label"][chosen])
        labels[:half, 0] *= -1.0
        labels = labels.to(self._device)
        with torch.autocast(self._device, self._type, enabled=self._type is not torch.float32):
            logits, progress = self.network.predict(tensors_of(sample).to(self._device))
        choice = option_loss(logits.float(), labels)
        return Loss(choice + PROGRESS * functional.cross_entropy(progress.float(), labels[:, 3].long()))

    def _samples(self, chosen: npt.NDArray[np.int64]) -> PolicyInput:
        """Return the inputs of decisions by index, as a batch."""
        arrays: Any = self._arrays
        return PolicyInput(*(arrays[name][chosen] for name in PolicyInput._fields))


def option_targets(labels: Tensor) -> Tensor:
    """Return soft targets of the options, (B, OPTIONS): a labelled position is spread over the nearest waypoints.

    Args:
        labels: (B, 4), the fields of `DecisionLabel`.
    """
    right, ahead, thing, _ = labels.float().unbind(1)
    distance = torch.hypot(right, ahead).clamp(min=DISTANCES[0]).log()
    far = soft_bins(distance, tuple(math.log(each) for each in DISTANCES))
    waypoints = (direction_bins(right, ahead)[:, :, None] * far[:, None]).flatten(1)
    is_thing = (thing >= 0.0)[:, None]
    things = functional.one_hot(thing.long().clamp(min=0), OPTIONS - WAYPOINTS)
    return torch.cat([waypoints * ~is_thing, things * is_thing], 1)


def option_loss(logits: Tensor, labels: Tensor) -> Tensor:
    """Return the mean cross-entropy of option logits, (B, OPTIONS), with labels, (B, 4)."""
    return -(option_targets(labels) * logits.log_softmax(1)).sum(1).mean()


class PlacementTask:
    """Training task: predict the target cell of a room. Batches must be drawn in order, from step 0 on.

    Args:
        network: network to train.
        tasks: training examples.
        batch: number of examples in a batch.
        seed: seed of the order, of the choice of readings, and of misnamed objects.
    """

    def __init__(self, network: PlacementNetwork, tasks: Sequence[RoomExample], batch: int, seed: int) -> None:
        self.network, self._tasks, self._batch = network, tasks, batch
        self._random, self._order = Random(seed), np.random.default_rng(seed)  # noqa: S311 - nothing here is a secret

    def loss(self, step: int) -> Loss:  # noqa: ARG002
        """Return the cross-entropy of the next batch."""
        chosen = [self._tasks[number] for number in self._order.integers(len(self._tasks), size=self._batch)]
        inputs = [
            placement_input(list(self._random.choice(task.readings)), with_naming_errors(task.room, self._random))
            for task in chosen
        ]
        targets = torch.tensor([CELLS.index(task.cell) for task in chosen])
        return Loss(functional.cross_entropy(self.network(stack_inputs(inputs)), targets))
