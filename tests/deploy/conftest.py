"""The wheels of this tree, and environments that hold them."""

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests import ROOT
from tests.physics import ANY_CAMERA
from tests.ports import free_port
from tests.shared import shared_folder
from tests.virtual_environments import Environment

SAMPLE = ROOT / "examples" / "sample"


@pytest.fixture(scope="session")
def wheels(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """The wheels that `scripts/wheels` makes, by the names of their distributions."""
    folder = shared_folder(tmp_path_factory, "wheels", _make_wheels)
    return {path.name.partition("-")[0].replace("_", "-"): path for path in sorted(folder.glob("*.whl"))}


def _make_wheels(folder: Path) -> None:
    command = [str(ROOT / "scripts" / "wheels"), str(folder), "--no-build-isolation"]
    subprocess.run(command, env={**os.environ, "PYTHON": sys.executable}, check=True, capture_output=True)


@pytest.fixture(scope="module")
def host(tmp_path_factory: pytest.TempPathFactory, wheels: dict[str, Path]) -> Environment:
    """An environment with all of them."""
    return Environment(tmp_path_factory.mktemp("host"), list(wheels.values()))


@pytest.fixture(scope="module")
def author(tmp_path_factory: pytest.TempPathFactory, wheels: dict[str, Path]) -> Environment:
    """An environment with what an agent's author needs."""
    return Environment(tmp_path_factory.mktemp("author"), [wheels["arramon-client"]])


@pytest.fixture(scope="module")
def sample(host: Environment, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A data folder with the sample, imported by the host's command."""
    folder = tmp_path_factory.mktemp("sample")
    done = host.run(f"arramon-server import-release {SAMPLE}/sample.json {SAMPLE}/sample_hindi.json", folder)
    assert done.returncode == 0, done.stderr
    return folder / "arramon-data"


@pytest.fixture
def served(host: Environment, sample: Path, tmp_path: Path) -> Iterator[tuple[str, str]]:
    """A server on a copy of the sample: its address, and that of its pages."""
    shutil.copytree(sample, tmp_path / "arramon-data")
    with serving(host, tmp_path) as addresses:
        yield addresses


@contextmanager
def serving(host: Environment, folder: Path) -> Iterator[tuple[str, str]]:
    """A server on the folder's `arramon-data`: its address, and that of its pages."""
    pages = f"127.0.0.1:{free_port()}"
    command = host.command(f"arramon-server serve --listen 127.0.0.1:0 --camera {ANY_CAMERA} --steps 20 --web {pages}")
    with subprocess.Popen(command, cwd=folder, env=host.variables(), stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        try:
            line = next(line for line in process.stdout if line.startswith("listening on "))
            yield line.split()[-1], pages
        finally:
            process.terminate()
    assert process.returncode == 0
