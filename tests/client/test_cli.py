"""The command: exit statuses, and what a participant reads."""

import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1 import types_pb2
from arramon_client.arguments import resume_command
from arramon_client.cli import main
from tests.client.fake import Servicer, World, serving

AGENTS = """
import os, signal
class Agent:
    sensors = ()
    def begin(self, episode): pass
    def act(self, observations): return [(int(o.episode_id[1:]) + o.step) % 4 for o in observations]
class Failing(Agent):
    def act(self, observations):
        if observations[0].step == 2: raise ValueError("no weights")
        return super().act(observations)
class Interrupting(Agent):
    def act(self, observations):
        if observations[0].step == 2: os.kill(os.getpid(), signal.SIGINT)
        return super().act(observations)
"""


@pytest.fixture
def address(world: World, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    (tmp_path / "cli_agents.py").write_text(AGENTS)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path])
    with serving(Servicer(world)) as served:
        yield served
    sys.modules.pop("cli_agents", None)


def test_a_run_from_beginning_to_end(world: World, address: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--agent", "cli_agents", "--lang", "en", "--server", address, "--participant", "me"]) == 0
    assert (world.run.agent, world.run.split, world.run.language) == ("cli_agents", "val_seen", "en")
    assert (world.run.participant, list(world.run.sensors)) == ("me", [])
    shown = capsys.readouterr()
    assert "run run-1: cli_agents plays 4 episodes of val_seen, en, 8 at once" in shown.err
    assert "20 steps in " in shown.err
    assert "nDTW" in shown.out
    assert "arramon 9.9.9 | val_seen | en" in shown.out
    assert "results: arramon-results/run-1.json" in shown.out
    assert len(json.loads(Path("arramon-results/run-1.json").read_text())["episodes"]) == 4


def test_scores_and_receipt_are_asked_for_until_the_server_is_back(
    world: World, address: str, capsys: pytest.CaptureFixture[str]
) -> None:
    world.away.update({"GetReport": 2, "GetReceipt": 2})
    assert main(["--agent", "cli_agents", "--lang", "en", "--server", address]) == 0
    shown = capsys.readouterr()
    assert "nDTW" in shown.out
    assert shown.err.count("the connection is lost (no server answers") == 2
    assert "there is no receipt: the fake server signs nothing" in shown.err


def test_settings_reach_the_server(world: World, address: str) -> None:
    arguments = ["--agent", "cli_agents", "--lang", "en", "--server", address, "--split", "val_seen", "--parallel", "3"]
    arguments += ["--sensors", "rgb,pose", "--image-size", "128", "--encoding", "zstd", "--output", "out", "--quiet"]
    assert main(arguments) == 0
    opening = world.opens[0]
    assert (opening.max_episodes, opening.image_size, opening.encoding) == (3, 128, 2)
    assert list(world.run.sensors) == ["rgb", "pose"]
    assert Path("out/run-1.json").exists()


def test_the_quality_reaches_the_server(world: World, address: str) -> None:
    world.info.encodings.append(types_pb2.ENCODING_JPEG)
    arguments = ["--agent", "cli_agents", "--lang", "en", "--server", address, "--encoding", "jpeg", "--quality", "75"]
    assert main(arguments) == 0
    assert (world.opens[0].encoding, world.opens[0].jpeg_quality) == (types_pb2.ENCODING_JPEG, 75)


def test_an_agent_that_fails_is_played_to_the_end_and_told(
    world: World, address: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["--agent", "cli_agents:Failing", "--lang", "en", "--server", address]) == 3
    shown = capsys.readouterr()
    assert "nDTW" in shown.out
    assert "the agent failed 1 time(s); 4 episode(s) were given up. The first time:" in shown.err
    assert 'if observations[0].step == 2: raise ValueError("no weights")' in shown.err
    assert "arramon_client/" not in shown.err
    failures = json.loads(Path("arramon-results/run-1.json").read_text())["agent_failures"]
    assert failures[0]["message"] == "act() raised ValueError: no weights"


@pytest.mark.parametrize(("arguments", "status", "said"), [
    (["--agent", "cli_agents", "--lang", "fr"], 2, "error: the server has no language 'fr'; it has en"),
    (["--agent", "cli_agents", "--lang", "en", "--split", "v"], 2, "the server has no split 'v'; it has val_seen"),
    (["--agent", "cli_agents", "--lang", "en", "--sensors", "oracle"], 2, "does not offer the sensor oracle"),
    (["--agent", "cli_agents", "--lang", "en", "--image-size", "99"], 2, "does not offer images of 99 pixels"),
    (["--agent", "cli_agents", "--lang", "en", "--encoding", "jpeg"], 2, "does not offer the encoding 'jpeg'"),
    (["--agent", "cli_agents", "--lang", "en", "--quality", "75"], 2, "--quality is for --encoding jpeg"),
    (["--agent", "cli_agents", "--lang", "en", "--quality", "101"], 2, "'101' is not a whole number from 1 to 100"),
    (["--agent", "cli_agents", "--lang", "en", "--quality", "0"], 2, "'0' is not a whole number from 1 to 100"),
    (["--agent", "cli_agents", "--lang", "en", "--parallel", "99"], 2, "at most 32 episodes at once"),
    (["--agent", "cli_agent", "--lang", "en"], 2, "there is no module cli_agent installed"),
    (["--agent", "cli_agents", "--lang", "en", "--output", "cli_agents.py"], 1, "cannot be written to cli_agents.py"),
    (["--agent", "cli_agents", "--resume", "run-9"], 1, "there is no run 'run-9' (NOT_FOUND)"),
    (["--agent", "cli_agents"], 2, "--lang is needed"),
    (["--agent", "cli_agents", "--lang", "en", "--episodes", "0"], 2, "'0' is not a whole number above 0"),
    (["--agent", "cli_agents", "--lang", "en", "--sensors", "nose"], 2, "no sensor 'nose': of rgb, depth"),
    (["--agent", "cli_agents", "--lang", "en", "--data", "x"], 2, "cannot be used together with --server"),
    (["--lang", "en"], 2, "required: --agent"),
])  # fmt: skip
def test_what_is_wrong_is_said_before_a_run_is_made(
    world: World, address: str, capsys: pytest.CaptureFixture[str], arguments: list[str], status: int, said: str
) -> None:
    assert main([*arguments, "--server", address]) == status
    shown = capsys.readouterr().err
    assert said in shown
    assert "Traceback" not in shown
    assert "--resume run" not in shown
    assert world.run.run_id == ""


def test_no_server(tmp_path: Path, address: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--agent", "cli_agents", "--lang", "en", "--server", f"unix:{tmp_path}/none"]) == 1
    assert f"error: no server answers at unix:{tmp_path}/none" in capsys.readouterr().err


def test_an_agent_that_cannot_be_imported_shows_its_own_traceback(
    tmp_path: Path, address: str, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "cli_broken.py").write_text("1 / 0")
    assert main(["--agent", "cli_broken", "--lang", "en", "--server", address]) == 2
    shown = capsys.readouterr().err
    assert "error: agent cli_broken: its module cli_broken cannot be imported" in shown
    assert "1 / 0" in shown
    assert "importlib" not in shown


def test_an_interrupt_says_how_to_go_on_and_going_on_finishes(
    world: World, address: str, capsys: pytest.CaptureFixture[str]
) -> None:
    begun = ["--agent", "cli_agents:Interrupting", "--lang", "en", "--server", address]
    assert main(begun) == 130
    shown = capsys.readouterr().err
    command = f"arramon-client --agent cli_agents:Interrupting --lang en --server {address} --resume run-1"
    assert f"interrupted\nthe run is kept; go on with it by\n  {command}\n" in shown
    assert world.causes == {}
    world.run.agent = "cli_agents"
    assert main(["--agent", "cli_agents", "--server", address, "--resume", "run-1"]) == 0
    assert world.actions == {f"e{i}": [(i + step) % 4 for step in range(5)] for i in range(4)}
    assert world.opens[-1].adopt


def test_a_complete_run_is_only_reported(world: World, address: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--agent", "cli_agents", "--lang", "en", "--server", address]) == 0
    assert main(["--agent", "cli_agents", "--server", address, "--resume", "run-1"]) == 0
    assert len(world.opens) == 1
    assert capsys.readouterr().out.count("nDTW") == 2


def test_a_client_that_resumes_waits_for_a_server_that_is_away(
    world: World, address: str, capsys: pytest.CaptureFixture[str]
) -> None:
    world.create(pb.CreateRunRequest(agent="cli_agents", split="val_seen", language="en"))
    world.away.update({"GetServerInfo": 2, "GetRun": 2})
    assert main(["--agent", "cli_agents", "--server", address, "--resume", "run-1"]) == 0
    shown = capsys.readouterr()
    assert shown.err.count(f"no connection yet (no server answers at {address}") == 1
    assert "nDTW" in shown.out


def test_a_new_run_does_not_wait_for_a_server_that_is_away(
    world: World, address: str, capsys: pytest.CaptureFixture[str]
) -> None:
    world.away["GetServerInfo"] = 1
    assert main(["--agent", "cli_agents", "--lang", "en", "--server", address]) == 1
    assert f"error: no server answers at {address}" in capsys.readouterr().err


def test_waiting_does_not_mend_an_encryption_that_is_not_there(
    world: World, address: str, capsys: pytest.CaptureFixture[str]
) -> None:
    world.create(pb.CreateRunRequest(agent="cli_agents", split="val_seen", language="en"))
    assert main(["--agent", "cli_agents", "--server", address, "--tls", "--resume", "run-1"]) == 1
    assert "it does not encrypt" in capsys.readouterr().err


@pytest.mark.parametrize(("changed", "said"), [
    (["--agent", "cli_agents:Failing"], "begun with --agent cli_agents, not cli_agents:Failing"),
    (["--agent", "cli_agents", "--lang", "hi"], "begun with --lang en, not hi"),
    (["--agent", "cli_agents", "--split", "train"], "begun with --split val_seen, not train"),
])  # fmt: skip
def test_a_run_is_resumed_as_what_it_was(
    world: World, address: str, capsys: pytest.CaptureFixture[str], changed: list[str], said: str
) -> None:
    world.create(pb.CreateRunRequest(agent="cli_agents", split="val_seen", language="en"))
    assert main([*changed, "--server", address, "--resume", "run-1"]) == 2
    assert said in capsys.readouterr().err


@pytest.mark.parametrize(("argv", "command"), [
    (["--agent", "a", "--lang", "en"], "arramon-client --agent a --lang en --resume r"),
    (["--agent", "a", "--resume", "q"], "arramon-client --agent a --resume r"),
    (["--resume=q", "--agent", "my agent"], "arramon-client --agent 'my agent' --resume r"),
])  # fmt: skip
def test_the_command_to_go_on(argv: list[str], command: str) -> None:
    assert resume_command(argv, "r") == command


def test_the_module_runs_as_a_program_and_takes_a_real_interrupt(world: World, address: str, tmp_path: Path) -> None:
    (tmp_path / "slow.py").write_text(
        "import time\nclass Agent:\n"
        "    def begin(self, e): print('begun', flush=True)\n    def act(self, o): time.sleep(60)"
    )
    arguments = ["--agent", "slow", "--lang", "en", "--server", address, "--parallel", "1"]
    program = [sys.executable, "-m", "arramon_client", *arguments]
    with subprocess.Popen(program, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as client:
        assert client.stdout is not None
        assert client.stdout.readline() == "begun\n"
        os.kill(client.pid, signal.SIGINT)
        _, errors = client.communicate(timeout=10)
    assert client.returncode == 130
    assert "--resume run-1" in errors
    assert "Traceback" not in errors
