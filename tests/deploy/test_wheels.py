"""Wheels: complete, and sufficient to play outside this repository."""

import json
import os
import re
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from urllib.request import urlopen

import pytest

from tests import ROOT
from tests.physics import ANY_CAMERA
from tests.programs import free_port
from tests.virtual_environments import Environment

SAMPLE = ROOT / "examples" / "sample"
PACKAGES = {"server": ".", "agents": ".", "lang": ".", "arramon": "proto", "arramon_client": "clients/python"}
"""Where each package lies."""

AGENT = """
class Agent:
    def begin(self, episode):
        pass

    def act(self, observations):
        return [3 for _ in observations]
"""

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def wheels(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    folder = tmp_path_factory.mktemp("wheels")
    command = [str(ROOT / "scripts" / "wheels"), str(folder), "--no-build-isolation"]
    subprocess.run(command, env={**os.environ, "PYTHON": sys.executable}, check=True, capture_output=True)
    return sorted(folder.iterdir())


@pytest.fixture(scope="module")
def host(tmp_path_factory: pytest.TempPathFactory, wheels: list[Path]) -> Environment:
    """An environment with all three."""
    return Environment(tmp_path_factory.mktemp("host"), wheels)


@pytest.fixture(scope="module")
def author(tmp_path_factory: pytest.TempPathFactory, wheels: list[Path]) -> Environment:
    """An environment with what an agent's author needs."""
    return Environment(tmp_path_factory.mktemp("author"), [wheel for wheel in wheels if "server" not in wheel.name])


@pytest.fixture(scope="module")
def sample(host: Environment, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A data folder with the sample, imported by the host's command."""
    folder = tmp_path_factory.mktemp("sample")
    done = host.run(f"arramon-server import-release {SAMPLE}/sample.json {SAMPLE}/sample_hindi.json", folder)
    assert done.returncode == 0, done.stderr
    return folder / "arramon-data"


def test_wheels_contain_exactly_the_package_files(wheels: list[Path]) -> None:
    assert [wheel.name.partition("-")[0] for wheel in wheels] == ["arramon_client", "arramon_proto", "arramon_server"]
    held: set[str] = set()
    for wheel in wheels:
        with zipfile.ZipFile(wheel) as archive:
            names = set(archive.namelist())
        assert any(name.endswith("licenses/LICENSE") for name in names), wheel.name
        held |= {name for name in names if ".dist-info/" not in name}
    there = {
        str(path.relative_to(ROOT / place))
        for package, place in PACKAGES.items()
        for path in (ROOT / place / package).rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }
    assert held == there


def test_agent_plays_with_only_the_client_wheel_installed(
    author: Environment, host: Environment, sample: Path, tmp_path: Path
) -> None:
    assert author.ours == {"arramon-client", "arramon-proto"}
    for missing in ("server", "agents", "pybullet", "sqlalchemy"):
        assert f"No module named '{missing}'" in author.run(f"python -c 'import {missing}'", tmp_path).stderr
    (tmp_path / "mine.py").write_text(AGENT)
    shutil.copytree(sample, tmp_path / "arramon-data")
    with serving(host, tmp_path) as (address, _):
        play = f"arramon-client --agent mine --lang hi --split sample --server {address} --episodes 1 --output results"
        played = author.run(play, tmp_path)
    assert played.returncode == 0, played.stderr
    assert finished(tmp_path / "results") == 1


def test_agent_image_has_what_its_default_agent_needs(
    host: Environment, wheels: list[Path], sample: Path, tmp_path: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    """Its packages are those that the Dockerfile names beside the client's, and the folders that it copies."""
    text = (ROOT / "Dockerfile").read_text()
    stage = text[text.index("AS agent-builder") : text.index("AS runtime")]
    torch = re.findall(r"^ARG TORCH=(\S+)$", stage, re.MULTILINE)
    others = re.findall(r"pip install ([a-z ]+)$", stage, re.MULTILINE)
    (folders,) = re.findall(r"cp -r ([a-z ]+) /opt/arramon/lib", stage)
    more = [*(each.partition("=")[0] for each in torch), *" ".join(others).split()]
    assert more[0] == "torch"
    mine = [wheel for wheel in wheels if "server" not in wheel.name]
    image = Environment(tmp_path_factory.mktemp("image"), mine, more)
    for folder in folders.split():
        shutil.copytree(ROOT / folder, image.site / folder)
    compose = (ROOT / "deploy" / "compose.yaml").read_text()
    options = [re.findall(rf"\$\{{ARRAMON_{name}:-([\w.]+)\}}", compose)[0] for name in ("AGENT", "LANG")]
    assert f"arramon-client --agent {options[0]} --lang {options[1]} " in (ROOT / "README.md").read_text()
    shutil.copytree(sample, tmp_path / "arramon-data")
    with serving(host, tmp_path) as (address, _):
        play = f"arramon-client --agent {options[0]} --lang {options[1]} --split sample --server {address} --episodes 1"
        played = image.run(
            f"{play} --output results", tmp_path, NUMBA_CACHE_DIR=str(tmp_path / "compiled"), OMP_NUM_THREADS="1"
        )
    assert played.returncode == 0, played.stderr
    assert finished(tmp_path / "results") == 1


def test_environments_without_gymnasium_say_what_they_need(author: Environment, tmp_path: Path) -> None:
    imported = author.run("python -c 'import arramon_client.environments'", tmp_path)
    assert "the environments need Gymnasium: pip install 'arramon-client[environments]'" in imported.stderr


def test_server_wheel_plays_embedded_and_serves_pages(host: Environment, sample: Path, tmp_path: Path) -> None:
    assert host.ours == {"arramon-client", "arramon-proto", "arramon-server"}
    shutil.copytree(sample, tmp_path / "arramon-data")
    play = (
        "arramon-client --agent agents.follower --lang hi --split sample --episodes 1 --image-size 128 --output results"
    )
    played = host.run(play, tmp_path, ARRAMON_CAMERA=ANY_CAMERA, ARRAMON_STEPS="20")
    assert played.returncode == 0, played.stderr
    assert finished(tmp_path / "results") == 1
    with serving(host, tmp_path) as (_, pages), urlopen(f"http://{pages}/hi/") as page:
        assert "लीडरबोर्ड" in page.read().decode()


@pytest.mark.parametrize("package", [True, False])
def test_agents_are_found_by_name_beside_a_folder_named_agents(
    host: Environment, tmp_path: Path, package: bool
) -> None:
    (tmp_path / "agents").mkdir()
    (tmp_path / "agents" / "mine.py").write_text(AGENT)
    (tmp_path / "lang.py").write_text("raise RuntimeError")
    if package:
        (tmp_path / "agents" / "__init__.py").touch()
    load = (
        "python -c 'import sys; from arramon_client import load_agent; print(type(load_agent(sys.argv[1])).__module__)'"
    )
    for name, module in (("agents.follower", "arramon_agents.follower.agent"), ("agents.mine", "agents.mine")):
        loaded = host.run(f"{load} {name}", tmp_path)
        assert (loaded.stdout, loaded.stderr) == (f"{module}\n", "")


def test_server_wheel_includes_street_plans_and_languages(host: Environment, tmp_path: Path) -> None:
    build = 'print(*(read_plan(id).id for id in plan_ids()), build_section(read_plan("1"), "seed").id)'
    assert host.run(f"python -c 'from arramon_dataset.plans import *; {build}'", tmp_path).stdout == "1 2 3 4 5 6 7 1\n"
    check = "arramon-server check-instruction --lang hi --phase navigation 'बाएँ मुड़ें और बेंच तक जाएँ।'"
    checked = host.run(check, tmp_path)
    assert checked.returncode == 0, checked.stderr


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


def finished(results: Path) -> int:
    """How many episodes the results of the one run in a folder hold."""
    (file,) = (path for path in results.iterdir() if not path.name.endswith(".receipt.json"))
    return len(json.loads(file.read_text())["episodes"])
