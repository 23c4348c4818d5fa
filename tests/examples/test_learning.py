"""The examples for learners and agents' authors run."""

import subprocess
import sys
from pathlib import Path

import pytest

from server.dataset.release.importer import import_release
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


def test_the_agent_plugin(data: Path, tmp_path: Path) -> None:
    arguments = ["--agent", "examples.my_agent", "--data", data, "--lang", "en", "--split", "sample", "--episodes", "2"]
    said = run("-m", "arramon_client", *arguments, "--output", tmp_path, "--quiet")
    assert "nDTW" in said
