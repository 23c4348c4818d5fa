"""What the policy of `vl_map` learns from: decisions with the right choice, kept as arrays, mirrored at random."""

import math
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt
import torch
from safetensors import safe_open
from safetensors.numpy import save_file
from torch import Tensor
from torch.nn import functional

from agents.learning.simulated.walks import Decided, Label
from agents.vl_map.features import DIRECTIONS, Sample, mirror
from agents.vl_map.network import PolicyNetwork, batch_of, directions_of, shares_of
from agents.vl_map.options import DISTANCES, OPTIONS, WAYPOINTS

KEPT = {"rows": np.uint8, "match": np.float16}
"""Types in which arrays are kept where their own is larger than they need."""

Arrays = dict[str, npt.NDArray[np.generic]]


def arrays_of(decided: Sequence[Decided]) -> Arrays:
    """Return decisions as arrays, with the labels as (n, 3)."""
    arrays: Arrays = {
        name: np.stack(part).astype(KEPT.get(name, part[0].dtype))
        for name, part in zip(Sample._fields, zip(*(each.sample for each in decided), strict=True), strict=True)
    }
    arrays["label"] = np.array([each.label for each in decided], np.float32)
    return arrays


def save_arrays(path: Path, arrays: Arrays, about: str, seconds: float) -> None:
    """Write arrays to a file, which appears complete or not at all.

    Args:
        path: the file.
        arrays: what is written.
        about: what they follow from.
        seconds: of processor time that they took.
    """
    new = path.with_suffix(".new")
    save_file(arrays, new, {"about": about, "seconds": str(seconds)})
    new.replace(path)


def load_arrays(path: Path, about: str) -> tuple[Arrays, float]:
    """Return the arrays of a file, and the seconds of processor time that they took.

    Raises:
        ValueError: if they follow from something else.
    """
    with safe_open(path, "np") as file:
        told = file.metadata() or {}
        if told.get("about") != about:
            raise ValueError(
                f"{path} follows from another recipe or other data: {told.get('about')}; name another folder"
            )
        arrays = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118 - not a mapping
    return arrays, float(told["seconds"])


class ChoosingTask:
    """To choose as the right decisions do.

    Args:
        network: that learns.
        seed: of the order of the decisions, and of mirroring.

    Attributes:
        count: of decisions to learn from.
    """

    def __init__(self, network: PolicyNetwork, seed: int) -> None:
        self.network, self._seed = network, seed
        self._parts: list[Arrays] = []
        self._ends: list[int] = []

    @property
    def count(self) -> int:
        """Number of decisions to learn from."""
        return self._ends[-1] if self._ends else 0

    def add(self, arrays: Arrays) -> None:
        """Add decisions."""
        self._parts.append(arrays)
        self._ends.append(self.count + len(arrays["label"]))

    def loss(self, numbers: range) -> Tensor:
        """Return the cross-entropy of a batch: decisions drawn at random, each as it is or its mirror image."""
        random = np.random.default_rng((self._seed, numbers.start))
        samples, labels = [], []
        for number in random.integers(self.count, size=len(numbers)).tolist():
            sample, label = self._get(number)
            if random.random() < 0.5:
                sample, label = mirror(sample), label._replace(right=-label.right)
            samples.append(sample)
            labels.append(label)
        return loss_of(self.network(batch_of(samples)), labels)

    def _get(self, number: int) -> tuple[Sample, Label]:
        part = next(place for place, end in enumerate(self._ends) if number < end)
        arrays = self._parts[part]
        place = number - (self._ends[part - 1] if part else 0)
        sample = Sample(*(arrays[name][place] for name in Sample._fields))
        sample = sample._replace(match=sample.match.astype(np.float32))
        right, ahead, thing = arrays["label"][place].tolist()
        return sample, Label(right, ahead, int(thing))


def targets_of(labels: Sequence[Label]) -> Tensor:
    """Return the share of each option that is right, (B, OPTIONS): of waypoints those around the right place."""
    right, ahead = (torch.tensor([label[part] for label in labels]) for part in (0, 1))
    distance = torch.hypot(right, ahead).clamp(min=DISTANCES[0]).log()
    far = shares_of(distance, tuple(math.log(each) for each in DISTANCES))
    waypoints = (directions_of(right, ahead)[:, :, None] * far[:, None]).flatten(1)
    targets = functional.pad(waypoints, (0, OPTIONS - WAYPOINTS))
    assert waypoints.shape[1] == DIRECTIONS * len(DISTANCES)
    for row, label in enumerate(labels):
        if label.thing >= 0:
            targets[row] = 0.0
            targets[row, WAYPOINTS + label.thing] = 1.0
    return targets


def loss_of(values: Tensor, labels: Sequence[Label]) -> Tensor:
    """Return the mean cross-entropy of options' values, (B, OPTIONS)."""
    return -(targets_of(labels) * values.log_softmax(1)).sum(1).mean()


def decisions_in(parts: Iterable[Arrays]) -> int:
    """Return how many decisions there are."""
    return sum(len(part["label"]) for part in parts)
