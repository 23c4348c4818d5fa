"""Errors for unreadable files of the learned reader."""

import json
from pathlib import Path

import pytest
import torch
from safetensors.torch import save_file

from arramon_agents.reading.reader.reader import WEIGHTS, read_reader
from arramon_agents.weights import BadWeights


def test_a_file_without_a_reader_is_named(tmp_path: Path) -> None:
    path = tmp_path / "reader.safetensors"
    with pytest.raises(BadWeights, match="there are no weights of the learned reader at"):
        read_reader(path)
    path.write_bytes(WEIGHTS.read_bytes()[:1000])
    with pytest.raises(BadWeights, match="is no file of weights: Error while deserializing"):
        read_reader(path)
    save_file({"a": torch.zeros(1)}, path)
    with pytest.raises(BadWeights, match="of the learned reader: its header has no 'words' that is a list"):
        read_reader(path)


@pytest.mark.parametrize(
    ("sizes", "words", "problem"),
    [
        ("[" * 200_000, "[]", "is nested more than 64 levels deep"),
        ("{}", "[" * 200_000, "is nested more than 64 levels deep"),
        ("{", "[]", "is not JSON, or was truncated"),
        ('{"words": NaN}', "[]", "has the number NaN"),
        ("[]", "[]", "its header has no 'sizes' that is a dict"),
        ("7", "[]", "its header has no 'sizes' that is a dict"),
        ("{}", "[]", "its header has 'sizes' without a size: .* 'words'"),
        ('{"words": 9, "layers": 2}', "[]", "its header has 'sizes' with words, layers; expected words, embedding"),
        ('{"words": "9"}', "[]", "its header has the size words '9', expected a whole number"),
        ('{"words": true}', "[]", "its header has the size words True, expected a whole number"),
        ('{"words": 9.5}', "[]", "its header has the size words 9.5, expected a whole number"),
        ('{"words": -1}', "[]", "its header has the size words -1, expected a whole number from 0 to 1048576"),
        (
            '{"words": 9, "encoder": 1099511627776}',
            "[]",
            "the size encoder 1099511627776, expected a whole",
        ),
        ('{"words": 9, "dropout": 2}', "[]", "its header has the size dropout 2, expected a number from 0 to 1"),
        ('{"words": 9}', '{"a": 1}', "its header has no 'words' that is a list"),
        ('{"words": 9}', "[1, 2]", "its header has 'words' that are no texts"),
        ('{"words": 9}', json.dumps(["a"] * 7), "it has no tensor words.weight"),
    ],
)
def test_wrong_types_in_a_readers_file_are_named(tmp_path: Path, sizes: str, words: str, problem: str) -> None:
    path = tmp_path / "reader.safetensors"
    save_file({"a": torch.zeros(1)}, path, {"sizes": sizes, "words": words})
    with pytest.raises(BadWeights, match=problem) as caught:
        read_reader(path)
    assert str(path) in str(caught.value)
    assert len(str(caught.value)) < 500
