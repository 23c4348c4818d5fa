"""A data folder with a small split, and one with the sample episodes of the release's form."""

from pathlib import Path

import pytest

from arramon_dataset.release.importer import import_release
from tests import ROOT, tiny


@pytest.fixture(scope="session")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("environments")
    tiny.write(folder)
    import_release([ROOT / "examples" / "sample" / "sample.json"], folder)
    return folder
