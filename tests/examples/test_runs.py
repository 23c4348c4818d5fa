"""The examples around a run: an agent that asks a model, the analysis of its results, and their chart."""

import subprocess
import sys
import xml.etree.ElementTree as ET
from collections import Counter
from pathlib import Path

import pytest

pytest.importorskip("openai", reason="the extra `agents` with vlm is not installed: scripts/setup dev")
pytest.importorskip("matplotlib", reason="the extra `docs` is not installed: scripts/setup dev")

from benchmarks.agents.fake_endpoint import ACTIONS, FakeEndpoint, Request, Response, completion, system_of
from examples import analyse_run
from tests import ROOT, tiny
from tests.agents.vlm import runs


def run(*arguments: object) -> str:
    done = subprocess.run(
        [sys.executable, *map(str, arguments)], capture_output=True, text=True, cwd=ROOT, timeout=300, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


class Expert:
    """Answers with the ground truth's actions of an instruction, one after the other."""

    def __init__(self) -> None:
        self._asked = Counter[str]()

    def __call__(self, request: Request, number: int) -> Response:
        instruction = system_of(request).rpartition("\n")[2]
        turn = int(instruction.rpartition("-")[2])
        room = not instruction.startswith(tiny.episode("0").instructions["en"][turn].navigation)
        begin, end = runs.PHASES[2 * turn + room]
        step = self._asked[instruction]
        self._asked[instruction] += 1
        # The first word is not one of the four: the agent turns right, and back.
        words = [
            *(["I would turn.", "left"] if begin == 0 else []),
            *(ACTIONS[each] for each in tiny.ACTIONS[begin:end]),
        ]
        return completion(request, words[step])


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The results file of a run with the expert behind an endpoint."""
    folder = tmp_path_factory.mktemp("run")
    runs.write(folder, 2)
    with FakeEndpoint(Expert()) as endpoint:
        run(
            "-m", "arramon_client", "--agent", "./examples/language_model.py", "--agent-arg", "model=fake",
            "--agent-arg", f"endpoint={endpoint.url}", "--data", folder, "--split", "tiny", "--lang", "en",
            "--image-size", "128", "--output", folder / "results", "--quiet",
        )  # fmt: skip
    assert endpoint.requests[0]["model"] == "fake"
    (found,) = (each for each in (folder / "results").glob("*.json") if ".receipt" not in each.name)
    return found


def test_a_model_plays_and_its_run_is_analysed(results: Path) -> None:
    said = run("examples/analyse_run.py", results).splitlines()
    assert said[0] == "language_model on tiny, en: 2 episodes"
    assert said[2].startswith("nDTW        1.000  95% interval 0.")
    assert said.count("     2 placed exactly") == 2
    assert "     2 AGENT_FINISHED" in said


@pytest.mark.parametrize(
    ("picked", "near", "placed", "expected"),
    [
        (1.0, 1.0, 1.0, "placed exactly"),
        (1.0, 1.0, 0.0, "right object, placed wrongly"),
        (0.0, 1.0, 1.0, "near the target, without it"),
        (0.0, 0.0, 1.0, "never near the target"),
    ],
)
def test_outcomes_of_turns(picked: float, near: float, placed: float, expected: str) -> None:
    assert analyse_run.outcome({"CTC-0": picked, "CTC-3": near, "PTC": placed}) == expected


def test_the_scores_of_runs_are_plotted(results: Path, tmp_path: Path) -> None:
    run("examples/plot_scores.py", tmp_path / "chart.svg", results, results)
    assert ET.parse(tmp_path / "chart.svg").getroot().tag.endswith("svg")
