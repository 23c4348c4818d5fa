"""Files of the reader that cannot be read."""

import json
from pathlib import Path

import pytest
import torch
from safetensors.torch import save_file

from arramon_agents.reading.reader.reader import WEIGHTS
from arramon_agents.reading.reader.weights import read_reader


def test_a_file_without_a_reader_is_named(tmp_path: Path) -> None:
    path = tmp_path / "reader.safetensors"
    with pytest.raises(FileNotFoundError, match="there is no reader at"):
        read_reader(path)
    path.write_bytes(WEIGHTS.read_bytes()[:1000])
    with pytest.raises(ValueError, match="holds no reader: Error while deserializing"):
        read_reader(path)
    save_file({"a": torch.zeros(1)}, path)
    with pytest.raises(ValueError, match="holds no reader: its metadata has no 'sizes' and 'words'"):
        read_reader(path)


@pytest.mark.parametrize(
    ("sizes", "words", "problem"),
    [
        ("[" * 200_000, "[]", "is nested more than 64 levels deep"),
        ("{}", "[" * 200_000, "is nested more than 64 levels deep"),
        ("{", "[]", "is not JSON, or was truncated"),
        ('{"words": NaN}', "[]", "has the number NaN"),
        ("[]", "[]", "its metadata has 'sizes' that are no object with words, embedding"),
        ("7", "[]", "its metadata has 'sizes' that are no object with words, embedding"),
        ("{}", "[]", "its metadata has 'sizes' that are no object with words, embedding"),
        ('{"words": 9, "layers": 2}', "[]", "its metadata has 'sizes' that are no object with words, embedding"),
        ('{"words": "9"}', "[]", "its metadata has the size words '9', expected a whole number"),
        ('{"words": true}', "[]", "its metadata has the size words True, expected a whole number"),
        ('{"words": 9.5}', "[]", "its metadata has the size words 9.5, expected a whole number"),
        ('{"words": -1}', "[]", "its metadata has the size words -1, expected 1 to 1048576"),
        ('{"words": 9, "encoder": 1099511627776}', "[]", "the size encoder 1099511627776, expected 1 to 1048576"),
        ('{"words": 9, "dropout": 2}', "[]", "its metadata has the size dropout 2, expected 0 to 1"),
        ('{"words": 9}', '{"a": 1}', "its metadata has 'words' that are no list of texts"),
        ('{"words": 9}', "[1, 2]", "its metadata has 'words' that are no list of texts"),
        ('{"words": 9}', json.dumps(["a"] * 7), "holds no reader: "),  # it has no tensors
    ],
)
def test_wrong_types_in_a_readers_file_are_named(tmp_path: Path, sizes: str, words: str, problem: str) -> None:
    path = tmp_path / "reader.safetensors"
    save_file({"a": torch.zeros(1)}, path, {"sizes": sizes, "words": words})
    with pytest.raises(ValueError, match=problem) as caught:
        read_reader(path)
    assert str(path) in str(caught.value)
    assert len(str(caught.value)) < 500
