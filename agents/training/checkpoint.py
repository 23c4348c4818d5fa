"""Checkpoints: the complete state of a training, from which it resumes with identical results."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from torch import Tensor

from arramon_agents.weights import SUFFIX, read_header, read_tensors, write_tensors

FORMAT = "training 1"

GROUPS = ("network", "optimizer", "average", "best", "history")
"""Groups of tensors in a file; the group is the first part of a tensor's name."""

OLD_SUFFIX = ".state"
"""Part of the file names of checkpoints of earlier versions."""

ZERO_IS_ALL = ("episodes",)
"""Settings of recipes of which 0 means all."""

RESUME_HINT = "name another --output, or remove it"


class CheckpointMismatch(ValueError):
    """A checkpoint belongs to another recipe, other data, or another version."""


@dataclass(frozen=True)
class TrainingInputs:
    """Recipe and data that determine a training; a checkpoint is only resumed if both match.

    Attributes:
        recipe: settings that affect updates, as JSON values.
        data: digest of the training data.
    """

    recipe: Mapping[str, Any]
    data: str


@dataclass
class TrainingCheckpoint:
    """State of a training after an update.

    Attributes:
        step: number of updates so far.
        cpu_seconds: processor time of updates and validations.
        scores: best score so far of each metric by which weights are chosen.
        tensors: by group (GROUPS) and name: the network's weights, optimizer state, averaged weights, weights with the
            best scores, and the loss of every update, (step,) float64.
    """

    step: int
    cpu_seconds: float
    scores: dict[str, float]
    tensors: dict[str, dict[str, Tensor]] = field(default_factory=dict)


def checkpoint_path(folder: Path, name: str) -> Path:
    """Return the path of the checkpoint of a training."""
    return folder / f"{name}.checkpoint{SUFFIX}"


def write_checkpoint(path: Path, checkpoint: TrainingCheckpoint, training_inputs: TrainingInputs) -> None:
    """Write a checkpoint to a file, atomically."""
    tensors = {
        f"{group}.{name}": value.detach().cpu().contiguous()
        for group in GROUPS
        for name, value in checkpoint.tensors[group].items()
    }
    header = {
        "format": FORMAT,
        "recipe": dict(training_inputs.recipe),
        "data": training_inputs.data,
        "step": checkpoint.step,
        "cpu_seconds": checkpoint.cpu_seconds,
        "scores": checkpoint.scores,
    }
    write_tensors(path, tensors, header)


def find_checkpoint(folder: Path, name: str) -> Path | None:
    """Return the path of the checkpoint of a training; None if there is none.

    Raises:
        CheckpointMismatch: if there is a checkpoint of an earlier version, under another name.
    """
    former = folder / f"{name}{OLD_SUFFIX}{SUFFIX}"
    if former.exists():
        raise CheckpointMismatch(
            f"{former} is a checkpoint of an earlier version, which cannot be resumed: {RESUME_HINT}"
        )
    path = checkpoint_path(folder, name)
    return path if path.exists() else None


def check_recipe(folder: Path, name: str, recipe: Mapping[str, Any]) -> None:
    """Check that a training can resume from its checkpoint, if there is one, before its data is made.

    Args:
        folder: output folder.
        name: name of the training.
        recipe: settings that affect updates, as in `TrainingInputs`.

    Raises:
        CheckpointMismatch: if the checkpoint belongs to another recipe or another version.
        BadWeights: if it cannot be read.
    """
    path = find_checkpoint(folder, name)
    if path is not None:
        _check_header(path, read_header(path), recipe)


def read_checkpoint(path: Path, training_inputs: TrainingInputs) -> TrainingCheckpoint:
    """Return the checkpoint of a file.

    Raises:
        CheckpointMismatch: if it belongs to another recipe, other data, or another version.
        BadWeights: if it cannot be read.
    """
    tensors, header = read_tensors(path)
    _check_header(path, header, training_inputs.recipe)
    if header["data"] != training_inputs.data:
        raise CheckpointMismatch(f"{path} is of other data: {RESUME_HINT}")
    by_group: dict[str, dict[str, Tensor]] = {group: {} for group in GROUPS}
    for name, value in tensors.items():
        group, _, rest = name.partition(".")
        by_group[group][rest] = value
    return TrainingCheckpoint(header["step"], header["cpu_seconds"], header["scores"], by_group)


def _check_header(path: Path, header: Mapping[str, Any], recipe: Mapping[str, Any]) -> None:
    """Check that a checkpoint's header has this version's format and a recipe."""
    if header.get("format") != FORMAT:
        raise CheckpointMismatch(f"{path} has the format {header.get('format')!r}, expected {FORMAT!r}: {RESUME_HINT}")
    if header["recipe"] != recipe:
        raise CheckpointMismatch(
            f"{path} is of another recipe ({_difference(header['recipe'], recipe)}): {RESUME_HINT}"
        )


def _difference(there: Mapping[str, Any], wanted: Mapping[str, Any]) -> str:
    """Return the first setting that differs, with both values."""
    name = next(name for name in (*wanted, *there) if there.get(name) != wanted.get(name))
    return f"{name} {_shown(name, there.get(name))}, expected {_shown(name, wanted.get(name))}"


def _shown(name: str, value: object) -> str:
    return "all" if name in ZERO_IS_ALL and value == 0 else repr(value)
