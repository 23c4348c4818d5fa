"""A data folder with the tiny split, and its exports in every format."""

from pathlib import Path

import pytest

from arramon_dataset.demonstrations.request import FORMATS
from tests import tiny
from tests.dataset.demonstrations.exports import export
from tests.shared import shared_folder


@pytest.fixture(scope="session")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    def fill(folder: Path) -> None:
        tiny.write(folder)
        tiny.write(folder, "secret", hidden=True)

    return shared_folder(tmp_path_factory, "demonstrations", fill)


@pytest.fixture(scope="session")
def exports(data: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Folders of complete exports, by format; not to be changed."""

    def fill(folder: Path) -> None:
        for name in FORMATS:
            export(data, folder / name, name)

    folder = shared_folder(tmp_path_factory, "exports", fill)
    return {name: folder / name for name in FORMATS}
