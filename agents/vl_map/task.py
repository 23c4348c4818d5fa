"""Training tasks of `vl_map`: labelled decisions, mirrored at random, for its policy; rooms for its other network."""

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

from arramon_agents.simulated.rooms import RoomExample, misnamed
from arramon_agents.simulated.walks import LabelledDecision
from arramon_agents.training.trainer import Loss
from arramon_agents.vl_map.features import PolicyInput, mirror
from arramon_agents.vl_map.network import PolicyNetwork, direction_bins, soft_bins, tensors_of
from arramon_agents.vl_map.options import DISTANCES, OPTIONS, WAYPOINTS
from arramon_agents.vl_map.room import CELLS, PlacementNetwork, placement_input, stack_inputs

PROGRESS = 0.3
"""Weight of the auxiliary loss for the row that is being carried out."""

KEPT = {"rows": np.uint8, "match": np.float16}
"""Smaller types in which some arrays are kept."""

Arrays = dict[str, npt.NDArray[np.generic]]


def arrays_of(decided: Sequence[LabelledDecision]) -> Arrays:
    """Return decisions as arrays, with the labels as (n, 4)."""
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
        arrays: what is written.
        about: settings from which the arrays follow.
        seconds: of processor time that they took.
    """
    new = path.with_suffix(".new")
    save_file(arrays, new, {"about": about, "seconds": str(seconds)})
    new.replace(path)


def load_arrays(path: Path, about: str) -> tuple[Arrays, float]:
    """Return the arrays of a file, and the seconds of processor time that they took.

    Raises:
        ValueError: if they are of other settings.
    """
    with safe_open(path, "np") as file:
        told = file.metadata() or {}
        if told.get("about") != about:
            raise ValueError(
                f"{path} follows from another recipe or other data: {told.get('about')}; name another folder"
            )
        arrays = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118 - not a mapping
    return arrays, float(told["seconds"])


class DecisionTask:
    """Training task: choose as the labels do.

    Args:
        network: to be trained.
        batch: number of decisions in a batch.
        seed: of the order of the decisions, and of mirroring.
        precision: "float32" or "bfloat16".
    """

    def __init__(self, network: PolicyNetwork, batch: int, seed: int, precision: str = "float32") -> None:
        self.network, self._batch, self._seed = network, batch, seed
        self._type = getattr(torch, precision)
        self._arrays: Arrays = {}

    @property
    def count(self) -> int:
        """Number of training decisions."""
        return len(self._arrays["label"]) if self._arrays else 0

    def add(self, arrays: Arrays) -> None:
        """Add decisions."""
        known = self._arrays
        self._arrays = {name: np.concatenate([known[name], new]) if known else new for name, new in arrays.items()}

    def loss(self, step: int) -> Loss:
        """Return the cross-entropy of a batch: decisions drawn at random, each as it is or its mirror image."""
        random = np.random.default_rng((self._seed, step * self._batch))
        chosen = random.integers(self.count, size=self._batch)
        half = self._batch // 2  # Half of the batch, which is in no order, is mirrored.
        parts: Any = mirror(self._samples(chosen[:half])), self._samples(chosen[half:])
        sample = PolicyInput(*(np.concatenate(part) for part in zip(*parts, strict=True)))
        labels = torch.tensor(self._arrays["label"][chosen])
        labels[:half, 0] *= -1.0
        with torch.autocast("cpu", self._type, enabled=self._type is not torch.float32):
            values, progress = self.network.predict(tensors_of(sample))
        choice = option_loss(values.float(), labels)
        return Loss(choice + PROGRESS * functional.cross_entropy(progress.float(), labels[:, 3].long()))

    def _samples(self, chosen: npt.NDArray[np.int64]) -> PolicyInput:
        """Return decisions by their numbers, with one more axis in front."""
        arrays: Any = self._arrays
        return PolicyInput(*(arrays[name][chosen] for name in PolicyInput._fields))


def option_targets(labels: Tensor) -> Tensor:
    """Return target probabilities of the options, (B, OPTIONS): those of waypoints spread around the right place.

    Args:
        labels: (B, 4), as `Label`.
    """
    right, ahead, thing, _ = labels.float().unbind(1)
    distance = torch.hypot(right, ahead).clamp(min=DISTANCES[0]).log()
    far = soft_bins(distance, tuple(math.log(each) for each in DISTANCES))
    waypoints = (direction_bins(right, ahead)[:, :, None] * far[:, None]).flatten(1)
    is_thing = (thing >= 0.0)[:, None]
    things = functional.one_hot(thing.long().clamp(min=0), OPTIONS - WAYPOINTS)
    return torch.cat([waypoints * ~is_thing, things * is_thing], 1)


def option_loss(values: Tensor, labels: Tensor) -> Tensor:
    """Return the mean cross-entropy of options' values, (B, OPTIONS), for labels, (B, 4)."""
    return -(option_targets(labels) * values.log_softmax(1)).sum(1).mean()


class PlacementTask:
    """Training task: find the cell of the room. Batches are drawn one after the other, from step 0 on.

    Args:
        network: to be trained.
        tasks: training tasks.
        batch: number of tasks in a batch.
        seed: of the order, the choice of readings, and misnamed things.
    """

    def __init__(self, network: PlacementNetwork, tasks: Sequence[RoomExample], batch: int, seed: int) -> None:
        self.network, self._tasks, self._batch = network, tasks, batch
        self._random, self._order = Random(seed), np.random.default_rng(seed)  # noqa: S311 - nothing here is a secret

    def loss(self, step: int) -> Loss:  # noqa: ARG002
        """Return the cross-entropy of the cells of the next batch."""
        chosen = [self._tasks[number] for number in self._order.integers(len(self._tasks), size=self._batch)]
        given = [
            placement_input(list(self._random.choice(task.readings)), misnamed(task.room, self._random))
            for task in chosen
        ]
        right = torch.tensor([CELLS.index(task.cell) for task in chosen])
        return Loss(functional.cross_entropy(self.network(stack_inputs(given)), right))
