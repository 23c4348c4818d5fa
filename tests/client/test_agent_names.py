"""Agents by name in a participant's folder: the project's agents, and the participant's modules."""

import os
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest

from tests import tiny
from tests.client.fake import Servicer, World, serving
from tests.physics import ANY_CAMERA

SHADOW = "raise RuntimeError('a module of the working directory was imported')\n"

OWN_AGENT = """
from arramon_agents.random_walk import Agent as RandomWalk
import lang
assert lang.WORDS
class Agent(RandomWalk):
    name = "own"
    sensors = ()
"""

OWN_BASE = """
import agents
assert agents.OWN
class Agent:
    def begin(self, episode): pass
    def act(self, observations): return [0 for _ in observations]
"""

MODULE = [sys.executable, "-m", "arramon_client"]
SCRIPT = [str(Path(sysconfig.get_path("scripts")) / "arramon-client")]


def client(program: list[str], folder: Path, *arguments: str) -> "subprocess.CompletedProcess[str]":
    command = [*program, "--lang", "en", "--output", "results", "--quiet", *arguments]
    environment = {**os.environ, "ARRAMON_CAMERA": ANY_CAMERA, "ARRAMON_STEPS": "20"}
    environment.pop("PYTHONPATH", None)
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=240)


def write(folder: Path, sources: dict[str, str]) -> None:
    for name, source in sources.items():
        (folder / name).parent.mkdir(exist_ok=True, parents=True)
        (folder / name).write_text(source)


@pytest.mark.parametrize("program", [MODULE, SCRIPT], ids=["module", "script"])
def test_project_agents_load_beside_modules_of_the_same_names(program: list[str], tmp_path: Path) -> None:
    names = ("server.py", "dataset.py", "agents/__init__.py", "agents/follower.py", "lang/__init__.py")
    write(tmp_path, dict.fromkeys(names, SHADOW))
    tiny.write(tmp_path / "arramon-data")
    played = client(program, tmp_path, "--agent", "agents.follower", "--episodes", "1", "--image-size", "128")
    assert played.returncode == 0, played.stderr
    assert "tiny" in played.stdout


@pytest.mark.parametrize("program", [MODULE, SCRIPT], ids=["module", "script"])
@pytest.mark.parametrize("files", [
    {"agents/mine.py": OWN_AGENT},
    {"agents/team/mine.py": OWN_AGENT},
    {"agents/mine.py": OWN_AGENT.replace("arramon_agents.random_walk", "agents.base"), "agents/base.py": OWN_BASE,
     "agents/__init__.py": "OWN = True"},
], ids=["folder", "nested", "package"])  # fmt: skip
def test_participants_agents_load_from_a_folder_named_agents(
    program: list[str], files: dict[str, str], tmp_path: Path
) -> None:
    write(tmp_path, {"server.py": SHADOW, "lang/__init__.py": "WORDS = ('left', 'right')", **files})
    name = next(iter(files)).removesuffix(".py").replace("/", ".")
    with serving(Servicer(World())) as address:
        played = client(program, tmp_path, "--agent", name, "--server", address)
    assert played.returncode == 0, played.stderr


@pytest.mark.parametrize("package", [True, False], ids=["package", "folder"])
def test_project_and_own_agents_load_beside_each_other(package: bool, tmp_path: Path) -> None:
    write(tmp_path, {"agents/mine.py": OWN_BASE.replace("assert", "#"), "lang.py": SHADOW, "server.py": SHADOW})
    if package:
        (tmp_path / "agents" / "__init__.py").touch()
    program = "import sys; from arramon_client import load_agent; print(type(load_agent(sys.argv[1])).__module__)"
    for name, module in (("agents.follower", "arramon_agents.follower.agent"), ("agents.mine", "agents.mine")):
        command = [sys.executable, "-c", program, name]
        loaded = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=120)
        assert (loaded.stdout, loaded.stderr) == (f"{module}\n", "")
