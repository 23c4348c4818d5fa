"""`arramon-server export-demos`: what it prints, what it refuses, and what a killed one leaves."""

import os
import signal
import subprocess
import sys
from contextlib import closing
from pathlib import Path

import pytest

from arramon_client.demonstrations import Demonstrations
from arramon_server import cli
from arramon_server.episodes.splits import read_split
from arramon_server.runs.storage.database import Database
from tests import played, tiny
from tests.dataset.demonstrations.exports import contents


@pytest.fixture
def data(tmp_path: Path) -> Path:
    tiny.write(tmp_path / "data")
    tiny.write(tmp_path / "data", "secret", hidden=True)
    with closing(Database(f"sqlite:///{tmp_path / 'data' / 'journal.db'}")) as database:
        played.play(database, read_split(tmp_path / "data" / "splits" / "tiny"), "walk", {"1": tiny.ACTIONS})
        hidden = read_split(tmp_path / "data" / "splits" / "secret")
        played.play(database, hidden, "hush", {"1": tiny.ACTIONS})
    return tmp_path / "data"


def command(data: Path, *arguments: object) -> int:
    return cli.main(["export-demos", "--data", str(data), "--jobs", "1", *map(str, arguments)])


def test_ground_truth(data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    output = tmp_path / "out"
    assert command(data, "--split", "tiny", "--format", "plain", "--lang", "hi", "--output", output) == 0
    said = capsys.readouterr()
    assert said.out == f"{output}: 4 episodes with 52 steps in hi\n"
    assert said.err.startswith("tiny: 4 of 4 episodes, 52 steps, ")
    assert len(Demonstrations(output)) == 4


def test_a_run(data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert command(data, "--run", "walk", "--format", "plain") == 0
    assert capsys.readouterr().out == "demonstrations/walk-plain: 1 episodes with 13 steps in en\n"
    (one,) = Demonstrations(Path("demonstrations/walk-plain"))
    assert one.episode_id == "1"


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--split", "secret", "--format", "plain"), "the split 'secret' is hidden"),
        (("--run", "hush", "--format", "plain"), "the split 'secret' is hidden"),
        (("--format", "plain"), "there is no split 'train' in"),
        (("--split", "tiny", "--format", "tar"), "there is no format 'tar'; there are minari, lerobot"),
        (("--split", "tiny", "--format", "minari", "--sensors", "rgb", "sonar"), "there is no sensor 'sonar'"),
        (("--split", "tiny", "--format", "minari", "--size", "31"), "the size is 31; expected a multiple of 8"),
        (("--split", "tiny", "--format", "plain", "--lang", "fr"), "the split 'tiny' has no language 'fr'"),
        (("--split", "tiny", "--format", "plain", "--jobs", "1000"), "the number of jobs is 1000; expected 1 to 256"),
        (("--split", "secret", "--run", "walk", "--format", "plain"), "run 'walk' was played on 'tiny', not on"),
        (("--run", "nobody", "--format", "plain"), "there is no run 'nobody'"),
    ],
)
def test_errors(
    data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], arguments: tuple[str, ...], said: str
) -> None:
    assert command(data, *arguments, "--output", tmp_path / "out") == 1
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.startswith("arramon-server: ")
    assert said in printed.err
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_a_killed_export_goes_on(tmp_path: Path) -> None:
    tiny.write(tmp_path / "data", count=64)
    arguments = ["--split", "tiny", "--format", "huggingface", "--sensors", "rgb", "--size", "16", "--lang", "en"]
    whole = [*arguments, "--data", str(tmp_path / "data"), "--jobs", "2", "--output", str(tmp_path / "out")]
    run = subprocess.Popen(
        [sys.executable, "-m", "arramon_server", "export-demos", *whole],
        stderr=subprocess.PIPE, text=True, start_new_session=True,
    )  # fmt: skip
    assert run.stderr is not None
    assert run.stderr.readline().startswith("tiny: 16 of 64 episodes")
    os.killpg(run.pid, signal.SIGKILL)
    run.wait()
    run.stderr.close()

    assert command(tmp_path / "data", *arguments, "--output", tmp_path / "out") == 0
    assert command(tmp_path / "data", *arguments, "--output", tmp_path / "undisturbed") == 0
    assert contents(tmp_path / "out") == contents(tmp_path / "undisturbed")
