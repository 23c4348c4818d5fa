"""A data folder with a small split to train on, in both languages."""

from pathlib import Path

import pytest

from tests import tiny

torch = pytest.importorskip("torch", reason="the extra `agents` is not installed: scripts/setup")
torch.set_num_threads(1)  # Several test processes share the cores.


@pytest.fixture(scope="session")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("learning")
    tiny.write(folder, "train")
    tiny.write(folder, "val_seen", 3)
    return folder
