"""The first set of episodes: generated only if the data folder has none."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from arramon_client import EmbeddedServerError, cli
from arramon_client.local import first_episodes
from arramon_client.local.first_episodes import holds_episodes, make_episodes
from arramon_dataset.generation.split_specs import SPLITS
from tests import ROOT

MAKER = """
import json, os, pathlib, sys
asked = dict(zip(sys.argv[2::2], sys.argv[3::2]))
assert sys.argv[1] == "generate" and asked.pop("--data") == {data!r}, sys.argv
folder = pathlib.Path({data!r}) / "splits" / asked["--split"]
folder.mkdir(parents=True)
print("12 of 12 episodes", flush=True)
(folder / "episodes.jsonl").write_text(json.dumps(asked))
"""


@pytest.fixture
def data(tmp_path: Path) -> Path:
    return tmp_path / "data"


@pytest.fixture
def module(tmp_path: Path, data: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """Name of a module that generates a split; a test may overwrite its source."""
    monkeypatch.setenv("PYTHONPATH", f"{tmp_path}{os.pathsep}{ROOT}")
    monkeypatch.syspath_prepend(str(tmp_path))
    (tmp_path / "scripted_maker.py").write_text(MAKER.format(data=str(data)))
    return "scripted_maker"


def test_a_small_split_is_generated_with_the_generators_output(
    module: str, data: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    assert not holds_episodes(data)
    make_episodes(data, module=module)
    assert holds_episodes(data)
    assert (data / "splits" / "val_unseen" / "episodes.jsonl").read_text() == (
        '{"--split": "val_unseen", "--scale": "0.01"}'
    )
    said = capfd.readouterr()
    assert (said.out, said.err) == ("", "12 of 12 episodes\n")


def test_quiet_generation_prints_nothing(module: str, data: Path, capfd: pytest.CaptureFixture[str]) -> None:
    make_episodes(data, module=module, quiet=True)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("name", ["splits/.new-1/val_unseen/episodes.jsonl", "splits/sections", "journal.db"])
def test_folders_without_a_split_hold_no_episodes(data: Path, name: str) -> None:
    (data / name).parent.mkdir(parents=True)
    (data / name).touch()
    assert not holds_episodes(data)


def test_a_failing_generator_prints_the_reason(
    module: str, data: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "scripted_maker.py").write_text("raise SystemExit('no room left on the disk')")
    with pytest.raises(EmbeddedServerError, match=r"episodes could not be generated: .* exited with status 1"):
        make_episodes(data, module=module)
    assert capfd.readouterr().err == "no room left on the disk\n"


def test_missing_server_package_is_reported(data: Path) -> None:
    with pytest.raises(EmbeddedServerError, match="arramon-server is not installed"):
        make_episodes(data, module="no_such_server")


def test_an_interrupt_stops_the_generator(module: str, data: Path, tmp_path: Path) -> None:
    (tmp_path / "scripted_maker.py").write_text(
        "import os, sys, time, pathlib\n"
        f"pathlib.Path({str(tmp_path / 'pid')!r}).write_text(str(os.getpid()) + '.')\n"
        "time.sleep(600)\n"
    )
    client = subprocess.Popen(
        [sys.executable, "-c", "import pathlib\nfrom arramon_client.local.first_episodes import make_episodes\n"
         f"make_episodes(pathlib.Path({str(data)!r}), module={module!r})"],
        stderr=subprocess.PIPE, text=True, cwd=tmp_path,
    )  # fmt: skip
    while not ((tmp_path / "pid").exists() and (tmp_path / "pid").read_text().endswith(".")):
        assert client.poll() is None, client.communicate()
        time.sleep(0.05)
    client.send_signal(signal.SIGINT)
    _, said = client.communicate(timeout=120)
    assert "KeyboardInterrupt" in said
    with pytest.raises(ProcessLookupError):
        os.kill(int((tmp_path / "pid").read_text().rstrip(".")), 0)


def play(data: Path, output: Path, *more: str) -> "subprocess.CompletedProcess[str]":
    asked = ["--agent", "agents.stop", "--lang", "hi", "--data", str(data), "--output", str(output), *more]
    command = [sys.executable, "-m", "arramon_client", *asked]
    return subprocess.run(command, capture_output=True, text=True, timeout=900, check=False, cwd=ROOT)


def test_missing_requested_split_is_reported_not_generated(data: Path, tmp_path: Path) -> None:
    done = play(data, tmp_path / "results", "--split", "val_seen")
    assert done.returncode == 1
    assert "no episodes in" in done.stderr
    assert not data.exists()


@pytest.mark.slow
def test_the_first_command_generates_episodes_and_plays_them(
    data: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """With one episode instead of twelve, each of which takes seconds, and few steps.

    In a folder whose modules have names of the project's own folders, and of modules of the library.
    """
    own = tmp_path / "own"
    for name in ("server", "dataset", "lang", "agents", "queue", "secrets"):
        (own / name).mkdir(parents=True)
        (own / name / "__init__.py").write_text("raise RuntimeError('a module of the working directory was imported')")
    monkeypatch.chdir(own)
    monkeypatch.setattr(sys, "path", [path for path in sys.path if path])
    monkeypatch.setattr(first_episodes, "SCALE", 1 / SPLITS[first_episodes.SPLIT].size)
    monkeypatch.setenv("ARRAMON_STEPS", "20")
    asked = ["--agent", "agents.stop", "--lang", "hi", "--data", str(data), "--output", str(tmp_path / "results")]
    assert cli.main(asked) == 0
    said = capfd.readouterr()
    assert said.err.startswith(f"no episodes in {data} yet: generating a small part of val_unseen (only once)\n")
    assert "1 of 1 episode" in said.err
    assert "on val_unseen, hi, 1 episode " in said.out
    assert cli.main([*asked, "--episodes", "1"]) == 0
    assert capfd.readouterr().err.startswith("run ")
