"""A data folder with a small split, in both languages, and a hidden one; windows are drawn to nowhere."""

from pathlib import Path

import pytest

from tests import tiny


@pytest.fixture(scope="session")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("environments")
    tiny.write(folder)
    tiny.write(folder, "secret", 3, hidden=True)
    return folder


@pytest.fixture(autouse=True)
def no_screen(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
