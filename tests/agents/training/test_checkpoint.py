"""Checkpoints that cannot be resumed are rejected with the reason."""

from pathlib import Path

import pytest
import torch
from safetensors.torch import save_file

from arramon_agents.training.checkpoint import (
    GROUPS,
    CheckpointMismatch,
    TrainingCheckpoint,
    TrainingInputs,
    checkpoint_path,
    find_checkpoint,
    read_checkpoint,
    write_checkpoint,
)
from arramon_agents.weights import BadWeights

IDENTITY = TrainingInputs({"languages": ["en", "hi"], "seed": 1}, "digest")


def test_what_was_written_is_read(tmp_path: Path) -> None:
    path = checkpoint_path(tmp_path, "vl")
    tensors = {group: {f"{number}.weight": torch.full((2,), float(number))} for number, group in enumerate(GROUPS)}
    write_checkpoint(path, TrainingCheckpoint(7, 1.5, {"nDTW": 0.25}, tensors), IDENTITY)
    assert find_checkpoint(tmp_path, "vl") == path
    found = read_checkpoint(path, IDENTITY)
    assert (found.step, found.cpu_seconds, found.scores) == (7, 1.5, {"nDTW": 0.25})
    assert {group: {name: value.tolist() for name, value in each.items()} for group, each in found.tensors.items()} == {
        group: {f"{number}.weight": [number, number]} for number, group in enumerate(GROUPS)
    }


def test_there_may_be_none(tmp_path: Path) -> None:
    assert find_checkpoint(tmp_path, "vl") is None


def test_checkpoints_of_earlier_versions_are_named(tmp_path: Path) -> None:
    save_file({"network.weight": torch.zeros(1)}, tmp_path / "vl_map.state.safetensors", {"done": "3"})
    with pytest.raises(CheckpointMismatch, match=r"vl_map\.state\.safetensors is a checkpoint of an earlier version"):
        find_checkpoint(tmp_path, "vl_map")
    path = checkpoint_path(tmp_path, "vl")
    save_file({"model.weight": torch.zeros(1)}, path, {"arramon": '{"step": 3, "recipe": {}}'})
    with pytest.raises(CheckpointMismatch, match="has the format None, expected 'training 1': name another --output"):
        read_checkpoint(path, IDENTITY)


def test_a_broken_file_is_named(tmp_path: Path) -> None:
    path = checkpoint_path(tmp_path, "vl")
    path.write_bytes(b"not a checkpoint")
    with pytest.raises(BadWeights, match=r"vl\.checkpoint\.safetensors"):
        read_checkpoint(path, IDENTITY)
