"""Source distributions and clones: what is installed from them is what the wheels hold."""

import re
import shutil
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import pytest

from tests import ROOT, tiny
from tests.deploy.test_dependencies import PROJECTS
from tests.deploy.test_wheels import play
from tests.physics import ANY_CAMERA
from tests.virtual_environments import PIP, Environment

PARTS = ("src", "server", "dataset", "collecting", "packages", "agents", "lang", "clients", "proto")
FILES = ("pyproject.toml", "README.md", "LICENSE")

SDIST = "import sys; from setuptools.build_meta import build_sdist; build_sdist(sys.argv[1])"

pytestmark = pytest.mark.slow


@pytest.fixture
def clone(tmp_path: Path) -> Path:
    """A copy of the source tree as git has it: with links, and without what was built in place."""
    made = tmp_path / "clone"
    made.mkdir()
    for name in PARTS:
        left_out = shutil.ignore_patterns("__pycache__", "*.egg-info", "build")
        shutil.copytree(ROOT / name, made / name, symlinks=True, ignore=left_out)
    for name in FILES:
        shutil.copy(ROOT / name, made)
    return made


def test_wheels_made_from_sdists_hold_the_same(wheels: dict[str, Path], clone: Path, tmp_path: Path) -> None:
    """The links of the source tree are files in the sdists, which can be unpacked anywhere."""
    for name, project in PROJECTS.items():
        there = clone / project.relative_to(ROOT)
        folder = tmp_path / name
        subprocess.run([sys.executable, "-c", SDIST, str(folder)], cwd=there, check=True, capture_output=True)
        (sdist,) = folder.iterdir()
        with tarfile.open(sdist) as archive:
            assert [member.name for member in archive if not (member.isfile() or member.isdir())] == []
        options = ("--no-deps", "--no-index", "--no-build-isolation", "--wheel-dir", str(folder))
        subprocess.run([*PIP, "wheel", *options, str(sdist)], cwd=tmp_path, check=True, capture_output=True)
        (wheel,) = folder.glob("*.whl")
        assert contents(wheel) == contents(wheels[name])


@pytest.mark.parametrize("options", [(), ("--editable",)], ids=["copy", "editable"])
def test_a_clone_is_installed_by_the_documented_command(
    options: tuple[str, ...], wheels: dict[str, Path], clone: Path, tmp_path: Path
) -> None:
    page = (ROOT / "docs" / "how-to" / "installing.md").read_text(encoding="utf-8")
    (given,) = re.findall(r"^pip install (.* \.)(?: +#.*)?$", page, re.MULTILINE)
    environment = Environment(tmp_path / "environment", list(wheels.values()), ["setuptools"])
    environment.uninstall(environment.ours)
    environment.install_sources(clone, *(word for path in given.split() for word in (*options, path)))
    environment.check()
    for name in ("", "_agents", "_client", "_collecting", "_dataset", "_lang", "_server"):
        package = f"arramon{name}"
        found = environment.run(f"python -c 'import {package}; print({package}.__file__)'", tmp_path).stdout
        assert found.startswith(str(clone if options else environment.site)), package
    tiny.write(tmp_path / "arramon-data", count=1)
    play(environment, "--agent agents.follower --lang en --image-size 128", tmp_path, ARRAMON_CAMERA=ANY_CAMERA)


def contents(wheel: Path) -> dict[str, bytes]:
    with zipfile.ZipFile(wheel) as archive:
        return {name: archive.read(name) for name in archive.namelist() if not name.endswith("/RECORD")}
