"""Data for the benchmarks' commands, made once for all test processes."""

import json
from pathlib import Path

import pytest

from arramon_dataset.release.importer import import_release
from tests import release_format, tiny
from tests.shared import shared_folder

EPISODES = 32
"""More than a benchmark plays in a moment."""

TEXTS = (
    "Go past the orange cone and the red bench to the dotted yellow ball.",
    "Walk towards the blue mailbox. Go straight on to the striped red tv.",
)


@pytest.fixture(scope="session")
def many(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A data folder with one split of many small episodes, with English and Hindi texts."""
    return shared_folder(tmp_path_factory, "benchmarks-many", lambda folder: _written(folder, "tiny", EPISODES))


@pytest.fixture(scope="session")
def release(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with `release.json`, a file like the official release's whose texts name furniture, and its import."""
    return shared_folder(tmp_path_factory, "benchmarks-release", _import)


def _written(folder: Path, name: str, count: int) -> None:
    tiny.write(folder, name, count)


def _import(folder: Path) -> None:
    records = [release_format.record(number) for number in range(1, 5)]
    for record in records:
        record["instructions"]["navi_inst_gt"] = list(TEXTS)
    (folder / "release.json").write_text(json.dumps(records))
    import_release([folder / "release.json"], folder)
