"""Installed beside `openai-agents`, whose package is named `agents`, as the names of this project's agents begin."""

import base64
import hashlib
import os
from importlib.metadata import distributions
from pathlib import Path

import pytest

from tests import tiny
from tests.deploy.test_wheels import play
from tests.physics import ANY_CAMERA
from tests.virtual_environments import Environment

OTHER = "openai-agents"
"""Downloaded for this test alone: of all that it requires, 14 packages of 60 MB are needed by nothing else here, and in
the environment of all tests a folder `agents` of a participant, without an `__init__.py`, would come after it."""

THEIRS = "python -c 'from agents import Agent; import agents; print(agents.__file__, Agent.__module__)'"

pytestmark = pytest.mark.slow


def test_both_work_in_either_order_of_installation(wheels: dict[str, Path], tmp_path: Path) -> None:
    environment = Environment(tmp_path / "environment", list(wheels.values()))
    download(environment)
    for order in ("ours-first", "theirs-first"):
        environment.check()
        folder = tmp_path / order
        tiny.write(folder / "arramon-data", count=1)
        check_theirs(environment, folder)
        check_ours(environment, folder)
        environment.uninstall(environment.ours)
        assert list(environment.site.glob("arramon*")) == []
        check_theirs(environment, folder)
        environment.install(list(wheels.values()))
    environment.uninstall([OTHER])
    assert "No module named 'agents'" in environment.run(THEIRS, folder).stderr
    check_ours(environment, folder)


def download(environment: Environment) -> None:
    """Installs the other package from the index; skips where there is none, but not in continuous integration."""
    said = environment.download(OTHER)
    is_missing = f"No matching distribution found for {OTHER}" in said.stderr and "from versions: none" in said.stderr
    if is_missing and not os.environ.get("CI"):
        pytest.skip(f"{OTHER} cannot be downloaded: pip reaches no package index that has it")
    assert said.returncode == 0, said.stdout + said.stderr


def check_theirs(environment: Environment, folder: Path) -> None:
    """What they installed is there, unchanged, and found under its name."""
    (theirs,) = (each for each in distributions(path=[str(environment.site)]) if each.metadata["Name"] == OTHER)
    files = [file for file in theirs.files or () if file.hash is not None]
    assert len(files) > 100
    for file in files:
        assert file.hash is not None
        digest = hashlib.new(file.hash.mode, Path(str(file.locate())).read_bytes()).digest()
        assert base64.urlsafe_b64encode(digest).rstrip(b"=").decode() == file.hash.value, file
    imported = environment.run(THEIRS, folder)
    assert imported.stdout == f"{environment.site / 'agents' / '__init__.py'} agents.agent\n", imported.stderr


def check_ours(environment: Environment, folder: Path) -> None:
    """Two of the project's agents play with an embedded server."""
    variables = {"ARRAMON_CAMERA": ANY_CAMERA, "NUMBA_CACHE_DIR": str(folder / "compiled")}
    for agent in ("agents.follower", "agents.random_walk"):
        play(environment, f"--agent {agent} --lang en --image-size 128", folder, **variables)
