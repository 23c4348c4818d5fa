"""Wheels: complete, and sufficient to play outside this repository."""

import json
import re
import shutil
import zipfile
from pathlib import Path
from urllib.request import urlopen

import pytest

from tests import ROOT, tiny
from tests.physics import ANY_CAMERA
from tests.virtual_environments import Environment

PACKAGES = {
    "arramon-agents": {"arramon_agents": "agents"},
    "arramon-client": {
        "arramon": "proto/arramon",
        "arramon_client": "clients/python/arramon_client",
        "arramon_verifiers": "clients/python/arramon_verifiers",
    },
    "arramon-lang": {"arramon_lang": "lang"},
    "arramon-server": {"arramon_collecting": "collecting", "arramon_dataset": "dataset", "arramon_server": "server"},
}
"""What each wheel holds: packages, and where they are."""

AGENT = """
class Agent:
    def begin(self, episode):
        pass

    def act(self, observations):
        return [3 for _ in observations]
"""

pytestmark = pytest.mark.slow


def test_wheels_contain_exactly_the_package_files(wheels: dict[str, Path]) -> None:
    assert list(wheels) == list(PACKAGES)
    for name, wheel in wheels.items():
        with zipfile.ZipFile(wheel) as archive:
            names = set(archive.namelist())
        assert any(each.endswith("licenses/LICENSE") for each in names), name
        there = {
            f"{package}/{path.relative_to(ROOT / folder)}"
            for package, folder in PACKAGES[name].items()
            for path in (ROOT / folder).rglob("*")
            if path.is_file() and "__pycache__" not in path.parts
        }
        assert {each for each in names if ".dist-info/" not in each} == there


def test_agent_plays_with_only_the_client_wheel_installed(
    author: Environment, served: tuple[str, str], tmp_path: Path
) -> None:
    assert author.ours == {"arramon-client"}
    for missing in ("arramon_server", "arramon_dataset", "arramon_agents", "arramon_lang", "pybullet", "sqlalchemy"):
        assert f"No module named '{missing}'" in author.run(f"python -c 'import {missing}'", tmp_path).stderr
    (tmp_path / "mine.py").write_text(AGENT)
    play(author, f"--agent mine --lang hi --server {served[0]}", tmp_path)


@pytest.mark.parametrize("agent", ["agents.random_walk", "agents.follower", "agents.shortest_path"])
def test_project_agents_play_on_a_host_without_a_server_installed(
    agent: str, wheels: dict[str, Path], served: tuple[str, str], tmp_path: Path
) -> None:
    """Those without weights: they do not need torch."""
    mine = [wheels[name] for name in ("arramon-agents", "arramon-client", "arramon-lang")]
    player = Environment(tmp_path / "player", mine)
    for missing in ("arramon_server", "arramon_dataset", "torch"):
        assert f"No module named '{missing}'" in player.run(f"python -c 'import {missing}'", tmp_path).stderr
    sensors = " --sensors rgb,depth,pose,oracle" if agent == "agents.shortest_path" else ""
    play(player, f"--agent {agent}{sensors} --lang hi --server {served[0]}", tmp_path)
    said = player.run("arramon-train --agent vl", tmp_path).stderr
    assert said.startswith("error: training needs torch and ")
    assert "`pip install 'arramon-agents[training]'`" in said


def test_agent_image_has_what_its_default_agent_needs(
    wheels: dict[str, Path], served: tuple[str, str], tmp_path: Path
) -> None:
    """It is made of the packages and extras that the Dockerfile installs."""
    text = (ROOT / "Dockerfile").read_text()
    stage = text[text.index("AS agent-builder") : text.index("AS runtime")]
    torch = re.findall(r"^ARG TORCH=(\w+)==", stage, re.MULTILINE)
    ((extra,),) = [re.findall(r"pip install ./packages/lang './packages/agents\[(\w+)\]'$", stage, re.MULTILINE)]
    mine = [wheels[name] for name in ("arramon-agents", "arramon-client", "arramon-lang")]
    image = Environment(tmp_path / "image", mine, [*torch, f"arramon-agents[{extra}]"])
    compose = (ROOT / "deploy" / "compose.yaml").read_text()
    agent, language = [re.findall(rf"\$\{{ARRAMON_{name}:-([\w.]+)\}}", compose)[0] for name in ("AGENT", "LANG")]
    assert f"arramon-client --agent {agent} --lang {language} " in (ROOT / "README.md").read_text()
    variables = {"NUMBA_CACHE_DIR": str(tmp_path / "compiled"), "OMP_NUM_THREADS": "1"}
    play(image, f"--agent {agent} --lang {language} --server {served[0]}", tmp_path, **variables)


def test_training_has_what_it_needs(wheels: dict[str, Path], tmp_path: Path) -> None:
    trainer = Environment(tmp_path / "trainer", list(wheels.values()), ["arramon-agents[training]"])
    for split, count in (("train", 2), ("val_seen", 1)):
        tiny.write(tmp_path / "arramon-data", split, count)
    train = "arramon-train --agent vl --smoke --encoder pooled --lang en"
    done = trainer.run(train, tmp_path, OMP_NUM_THREADS="1", NUMBA_CACHE_DIR=str(tmp_path / "compiled"))
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "arramon-weights" / "vl.safetensors").is_file()


def test_plain_demonstrations_need_no_extra(host: Environment, sample: Path, tmp_path: Path) -> None:
    shutil.copytree(sample, tmp_path / "arramon-data")
    export = "arramon-server export-demos --split sample --format plain"
    done = host.run(export, tmp_path, NUMBA_CACHE_DIR=str(tmp_path / "compiled"))
    assert done.returncode == 0, done.stderr


def test_environments_without_gymnasium_say_what_they_need(author: Environment, tmp_path: Path) -> None:
    imported = author.run("python -c 'import arramon_client.environments'", tmp_path)
    assert "the environments need Gymnasium: pip install 'arramon-client[environments]'" in imported.stderr


def test_environments_without_a_server_say_what_they_need(wheels: dict[str, Path], tmp_path: Path) -> None:
    learner = Environment(tmp_path / "learner", [wheels["arramon-client"]], ["arramon-client[environments]"])
    make = 'import gymnasium; gymnasium.make("arramon_client.environments:arramon/ArraMon-v0")'
    said = learner.run(f"python -c '{make}'", tmp_path).stderr
    assert said.splitlines()[-1].endswith(
        "NoBackend: without server=... an environment plays in this process, but arramon-server is not installed: "
        "install it, or name a host with server='HOST:PORT'"
    )


def test_server_wheel_plays_embedded_and_serves_pages(
    host: Environment, served: tuple[str, str], tmp_path: Path
) -> None:
    assert host.ours == set(PACKAGES)
    with urlopen(f"http://{served[1]}/hi/") as page:
        assert "लीडरबोर्ड" in page.read().decode()
    play(host, "--agent agents.follower --lang hi --image-size 128", tmp_path, ARRAMON_CAMERA=ANY_CAMERA)


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


def play(environment: Environment, arguments: str, folder: Path, **variables: str) -> None:
    """Plays one episode of the only split in the folder's `arramon-data` to its end."""
    (split,) = (path.parent.name for path in (folder / "arramon-data" / "splits").glob("*/episodes.jsonl"))
    results = folder / f"results-{len(list(folder.glob('results-*')))}"
    command = f"arramon-client {arguments} --split {split} --episodes 1 --output {results}"
    played = environment.run(command, folder, ARRAMON_STEPS="20", **variables)
    assert played.returncode == 0, played.stderr
    (file,) = (path for path in results.iterdir() if not path.name.endswith(".receipt.json"))
    assert len(json.loads(file.read_text())["episodes"]) == 1
