"""The examples for learners and agents' authors run."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from arramon_dataset.generation.command import generate_rooms
from arramon_dataset.release.importer import import_release
from tests import ROOT

SAMPLE = ROOT / "examples" / "sample"


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("examples")
    import_release([SAMPLE / "sample.json", SAMPLE / "sample_hindi.json"], folder)
    return folder


def run(*arguments: object) -> str:
    done = subprocess.run(
        [sys.executable, "-W", "error::UserWarning", *map(str, arguments)],
        capture_output=True,
        text=True,
        cwd=ROOT,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_random_agent(data: Path) -> None:
    said = run("examples/random_agent.py", data, "sample")
    assert "begins with:" in said
    assert " steps, STEP_LIMIT, nDTW 0." in said


def test_rollouts(data: Path) -> None:
    said = run("examples/collect_rollouts.py", data, "sample").splitlines()
    assert [line.partition(":")[0] for line in said] == ["rollout 0", "rollout 1", "rollout 2"]
    assert "'rgb': (32, 8, 64, 64, 3)" in said[-1]


@pytest.fixture(scope="module")
def rooms(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Holds twelve tasks in the room alone."""
    folder = tmp_path_factory.mktemp("rooms")
    generate_rooms(folder, 12, seed=1, jobs=1, on_progress=lambda _: None)
    return folder


def test_ppo(rooms: Path) -> None:
    """In short form it learns nothing: what it learns in ten minutes stands in its description."""
    said = run("-m", "examples.ppo_room", rooms, 2048, 7, 2)
    assert re.fullmatch(r"seed 7: PTC [01]\.\d{3} before, [01]\.\d{3} after 2048 steps\n", said)


def test_stable_baselines_on_a_vector(data: Path) -> None:
    said = run("-m", "examples.sb3_vector", data, "sample", 1024)
    assert re.fullmatch(r"1024 steps, ([1-9]\d*) episodes, mean return -?\d\.\d\d\n", said)


def test_torchrl(data: Path) -> None:
    said = run("-m", "examples.torchrl_ppo", data, "sample", 512).splitlines()
    assert said[0] == "instructions:"
    assert len([line for line in said if line.startswith("  ")]) == 4
    assert said[-2] == "a vector's texts: 4 episodes, 4 steps"
    found = re.fullmatch(r"512 steps, (\d+) of them in turn 2, mean reward -?\d\.\d{4}", said[-1])
    assert found is not None
    assert int(found[1]) > 0


def test_imitation(rooms: Path, tmp_path: Path) -> None:
    """In short form: it learns the exported actions of twelve tasks, almost by heart."""
    export = ["export-demos", "--data", rooms, "--split", "rooms", "--format", "plain", "--lang", "en", "--jobs", "1"]
    run("-m", "arramon_server", *export, "--output", tmp_path)
    said = run("-m", "examples.imitate_room", tmp_path, rooms, 12, 7, 2)
    ptc = r"[01]\.\d{3}"
    found = re.fullmatch(
        rf"seed 7: PTC {ptc} before, {ptc} after 12 demonstrations, {ptc} corrected, loss (\d\.\d\d)\n", said
    )
    assert found is not None
    assert float(found[1]) < 1.0


def test_the_agent_plugin(data: Path, tmp_path: Path) -> None:
    arguments = ["--agent", "examples.my_agent", "--data", data, "--lang", "en", "--split", "sample", "--episodes", "2"]
    said = run("-m", "arramon_client", *arguments, "--output", tmp_path, "--quiet")
    assert "nDTW" in said
