"""Files of weights: round trips, and errors for files with other content."""

from dataclasses import dataclass
from pathlib import Path

import pytest

pytest.importorskip("torch", reason="the extra `agents` is not installed: scripts/setup")

import torch

from arramon_agents.weights import (
    BadWeights,
    file_of,
    find_initial,
    find_weights,
    read_weights_file,
    write_tensors,
    write_weights_file,
)


@dataclass(frozen=True)
class Sizes:
    """Sizes of a network of the tests."""

    inputs: int
    share: float = 0.5
    has_bias: bool = True
    name: str = "plain"


def network(inputs: int = 2) -> torch.nn.Linear:
    torch.manual_seed(inputs)
    return torch.nn.Linear(inputs, 3)


@pytest.mark.parametrize("dtype", [torch.float16, torch.float32])
def test_networks_come_back_as_they_were_written(tmp_path: Path, dtype: torch.dtype) -> None:
    path, header = tmp_path / "new" / "w.safetensors", {"format": "test 1", "sizes": {"inputs": 2}}
    write_weights_file(path, {"one.": network(), "two.": network(4)}, header, {"words": "हिन्दी".encode()}, dtype)
    file = read_weights_file(path, "a test", "test 1")
    assert file.sizes("sizes", Sizes) == Sizes(2)
    assert file.blob("words").decode() == "हिन्दी"
    again = torch.nn.Linear(4, 3)
    file.fill(again, "two.")
    assert torch.equal(again.weight, network(4).weight.to(dtype).float())
    assert not again.training
    assert [each.name for each in path.parent.iterdir()] == ["w.safetensors"]


@pytest.mark.parametrize(
    ("sizes", "problem"),
    [
        (None, "its header has no 'sizes' that is a dict"),
        ([2], "its header has no 'sizes' that is a dict"),
        ({"outputs": 3}, "its header has 'sizes' with outputs; expected inputs, share, has_bias, name"),
        ({}, "its header has 'sizes' without a size"),
        ({"inputs": -1}, "the size inputs -1, expected a whole number from 0 to 1048576"),
        ({"inputs": True}, "the size inputs True, expected a whole number"),
        ({"inputs": 2.5}, "the size inputs 2.5, expected a whole number"),
        ({"inputs": 2, "share": 1.0}, "the size share 1.0, expected a number from 0 to 1"),
        ({"inputs": 2, "has_bias": 1}, "the size has_bias 1, expected true or false"),
        ({"inputs": 2, "name": 7}, "the size name 7, expected a name"),
    ],
)
def test_wrong_sizes_are_named(tmp_path: Path, sizes: object, problem: str) -> None:
    path = tmp_path / "w.safetensors"
    write_weights_file(path, {"": network()}, {"format": 1, "sizes": sizes})
    file = read_weights_file(path, "a test", 1)
    with pytest.raises(BadWeights, match=problem) as caught:
        file.sizes("sizes", Sizes)
    assert str(path) in str(caught.value)


@pytest.mark.parametrize(
    ("tensors", "problem"),
    [
        ({"weight": torch.zeros(3, 2)}, "it has no tensor bias"),
        ({"weight": torch.zeros(3, 4), "bias": torch.zeros(3)}, r"weight has the shape \(3, 4\), expected \(3, 2\)"),
        ({"weight": torch.zeros(3, 2), "bias": torch.zeros(3), "more": torch.zeros(1)}, "it has a tensor more"),
    ],
)
def test_wrong_tensors_are_named(tmp_path: Path, tensors: dict[str, torch.Tensor], problem: str) -> None:
    write_tensors(tmp_path / "w.safetensors", tensors, {"format": 1})
    file = read_weights_file(tmp_path / "w.safetensors", "a test", 1)
    with pytest.raises(BadWeights, match=f"does not hold the weights of a test: .*{problem}"):
        file.fill(network())
    with pytest.raises(BadWeights, match="it has no tokenizer"):
        file.blob("tokenizer")


def test_sizes_with_which_no_network_can_be_built_are_named(tmp_path: Path) -> None:
    write_tensors(tmp_path / "w.safetensors", {"a": torch.zeros(1)}, {"format": 1})
    file = read_weights_file(tmp_path / "w.safetensors", "a test", 1)
    with pytest.raises(BadWeights, match="no network has the sizes in its header: embed_dim must be divisible"):
        file.build(lambda: torch.nn.MultiheadAttention(7, 2))


def test_files_are_found_by_agent_and_by_path(tmp_path: Path) -> None:
    trained, shipped = tmp_path / "vl.safetensors", tmp_path / "vl_map" / "weights.safetensors"
    shipped.parent.mkdir()
    for path in (trained, shipped):
        path.write_bytes(b"")
    assert file_of(tmp_path, "vl") == find_initial(str(tmp_path), "vl") == find_weights(str(trained)) == trained
    assert file_of(tmp_path, "vl_map") == find_initial(str(tmp_path), "vl_map") == shipped
    assert find_weights("vl").parent.name == "vl"
    with pytest.raises(BadWeights, match="there are no weights"):
        find_initial(str(tmp_path), "vl_grounded")
    with pytest.raises(BadWeights, match="there are no weights of a test at"):
        read_weights_file(tmp_path / "nowhere", "a test", 1)
