"""Files of the reader that cannot be read."""

from pathlib import Path

import pytest
import torch
from safetensors.torch import save_file

from agents.learning.reader.reader import WEIGHTS
from agents.learning.reader.weights import read_reader


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
