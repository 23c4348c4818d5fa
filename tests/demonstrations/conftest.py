"""A data folder with the tiny split, and its exports in every format."""

from pathlib import Path

import pytest

from server.demonstrations.request import FORMATS
from tests import tiny
from tests.demonstrations.exporting import export


@pytest.fixture(scope="session")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("demonstrations")
    tiny.write(folder)
    tiny.write(folder, "secret", hidden=True)
    return folder


@pytest.fixture(scope="session")
def exports(data: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Folders of complete exports, by format; not to be changed."""
    folder = tmp_path_factory.mktemp("exports")
    for name in FORMATS:
        export(data, folder / name, name)
    return {name: folder / name for name in FORMATS}
