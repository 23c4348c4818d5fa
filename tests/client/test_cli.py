"""The command `arramon-client`: exit statuses and messages."""

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
from arramon_client import async_play
from arramon_client.arguments import resume_command
from arramon_client.cli import main
from tests.client.fake import RUN, Servicer, World, serving

AGENTS = """
import os, signal
import arramon_client
class Agent:
    sensors = ()
    def begin(self, episode): pass
    def act(self, observations): return [(int(o.episode_id[1:]) + o.step) % 4 for o in observations]
class Failing(Agent):
    def act(self, observations):
        if observations[0].step == 2: raise ValueError("no weights")
        return super().act(observations)
class Taking(Agent):
    def __init__(self, checkpoint, beam=4):
        assert (checkpoint, beam) == ("my w.pt", 4), (checkpoint, beam)
class Interrupting(Agent):
    def act(self, observations):
        if observations[0].step == 2: os.kill(os.getpid(), signal.SIGINT)
        return super().act(observations)
class Waiting(Agent):
    failures = 3
    asked = []
    async def act(self, o):
        self.asked.append((o.episode_id, o.step))
        if (o.episode_id, o.step) == ("e1", 2) and Waiting.failures > 0:
            Waiting.failures -= 1
            raise ConnectionError("away")
        return Agent.act(self, [o])[0]
    def replay(self, o, action): pass
class Limited(Waiting):
    async def act(self, o):
        if o.step == 2: raise arramon_client.StopRun("8 of 8 calls are used up")
        return await super().act(o)
"""


OTHER = "2e" * 16
"""The id of a run that is not there."""


@pytest.fixture
def address(world: World, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    (tmp_path / "cli_agents.py").write_text(AGENTS)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path])
    with serving(Servicer(world)) as served:
        yield served
    sys.modules.pop("cli_agents", None)


def test_run_is_played_reported_and_saved(world: World, address: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--agent", "cli_agents", "--lang", "en", "--server", address, "--participant", "me"]) == 0
    assert (world.run.agent, world.run.split, world.run.language) == ("cli_agents", "val_seen", "en")
    assert (world.run.participant, list(world.run.sensors)) == ("me", [])
    shown = capsys.readouterr()
    assert f"run {RUN}: cli_agents plays 4 episodes of val_seen, en, 8 in parallel" in shown.err
    assert "20 steps in " in shown.err
    assert "nDTW" in shown.out
    assert "arramon 9.9.9 | val_seen | en" in shown.out
    assert f"results: arramon-results/{RUN}.json" in shown.out
    assert len(json.loads(Path(f"arramon-results/{RUN}.json").read_text())["episodes"]) == 4


def test_an_agent_that_waits_is_retried_stopped_and_resumed(
    world: World, address: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(async_play, "FIRST_DELAY", 0.0)
    begun = ["--agent", "cli_agents:Waiting", "--lang", "en", "--server", address, "--retries", "1"]
    assert main(begun) == 3
    shown = capsys.readouterr()
    assert (
        "error: run stopped: the agent failed at step 2 of episode e1: act() raised ConnectionError: away" in shown.err
    )
    assert f"resume it with\n  arramon-client {' '.join(begun)} --resume {RUN}\n" in shown.err
    assert (world.reasons, world.actions["e1"]) == ({}, [1, 2])
    assert main([*begun, "--resume", RUN]) == 0
    assert world.actions == {f"e{i}": [(i + step) % 4 for step in range(5)] for i in range(4)}
    asked = sys.modules["cli_agents"].Waiting.asked
    assert (len(asked), len(set(asked)), asked.count(("e1", 2))) == (23, 20, 4)  # Three calls failed.


def test_an_agent_that_waits_can_give_up_an_episode(world: World, address: str) -> None:
    arguments = ["--agent", "cli_agents:Waiting", "--lang", "en", "--server", address, "--retries", "0"]
    assert main([*arguments, "--on-failure", "give-up"]) == 3
    assert world.reasons == {"e1": "act() raised ConnectionError: away"}
    assert len(world.causes) == 4


@pytest.mark.parametrize("option", [["--retries", "1"], ["--on-failure", "stop"]])
def test_other_agents_have_no_retries(
    world: World, address: str, capsys: pytest.CaptureFixture[str], option: list[str]
) -> None:
    assert main(["--agent", "cli_agents", "--lang", "en", "--server", address, *option]) == 2
    assert "--retries and --on-failure apply to an agent whose act is `async`" in capsys.readouterr().err
    assert world.requests == []


def test_an_agent_stops_its_run_in_order(world: World, address: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--agent", "cli_agents:Limited", "--lang", "en", "--server", address]) == 4
    shown = capsys.readouterr()
    assert "the agent stopped the run: 8 of 8 calls are used up\n" in shown.err
    assert f"--resume {RUN}" in shown.err
    assert (world.causes, world.reasons) == ({}, {})


def test_report_and_receipt_are_requested_until_the_server_is_back(
    world: World, address: str, capsys: pytest.CaptureFixture[str]
) -> None:
    world.away.update({"GetReport": 2, "GetReceipt": 2})
    assert main(["--agent", "cli_agents", "--lang", "en", "--server", address]) == 0
    shown = capsys.readouterr()
    assert "nDTW" in shown.out
    assert shown.err.count("connection lost (no server answers") == 2
    assert "no receipt: the fake server signs nothing" in shown.err


def test_settings_reach_the_server(world: World, address: str) -> None:
    arguments = ["--agent", "cli_agents", "--lang", "en", "--server", address, "--split", "val_seen", "--parallel", "3"]
    arguments += ["--sensors", "rgb,pose", "--image-size", "128", "--encoding", "zstd", "--output", "out", "--quiet"]
    assert main(arguments) == 0
    opening = world.opens[0]
    assert (opening.max_episodes, opening.image_size, opening.encoding) == (3, 128, 2)
    assert list(world.run.sensors) == ["rgb", "pose"]
    assert Path(f"out/{RUN}.json").exists()


def test_the_quality_reaches_the_server(world: World, address: str) -> None:
    world.info.encodings.append(types_pb2.ENCODING_JPEG)
    arguments = ["--agent", "cli_agents", "--lang", "en", "--server", address, "--encoding", "jpeg", "--quality", "75"]
    assert main(arguments) == 0
    assert (world.opens[0].encoding, world.opens[0].jpeg_quality) == (types_pb2.ENCODING_JPEG, 75)


def test_a_failing_agent_stops_the_run_and_the_resume_command_is_printed(
    world: World, address: str, capsys: pytest.CaptureFixture[str]
) -> None:
    begun = ["--agent", "cli_agents:Failing", "--lang", "en", "--server", address]
    assert main(begun) == 3
    shown = capsys.readouterr()
    said = "error: run stopped: the agent failed in 4 episodes in a row: act() raised ValueError: no weights"
    assert said in shown.err
    assert 'if observations[0].step == 2: raise ValueError("no weights")' in shown.err
    assert f"resume it with\n  arramon-client {' '.join(begun)} --resume {RUN}\n" in shown.err
    assert "--keep-going" in shown.err
    assert "nDTW" not in shown.out
    assert (world.causes, world.reasons, list(Path("arramon-results").iterdir())) == ({}, {}, [])
    world.run.agent = "cli_agents"
    assert main(["--agent", "cli_agents", "--server", address, "--resume", RUN]) == 0
    assert world.actions == {f"e{i}": [(i + step) % 4 for step in range(5)] for i in range(4)}


@pytest.mark.parametrize("hidden", [True, False])
def test_a_dry_run_plays_two_episodes_of_an_open_split(
    world: World, address: str, capsys: pytest.CaptureFixture[str], hidden: bool
) -> None:
    offered = ["rgb", "depth", "segmentation", "pose"]
    for name, languages, sensors in (
        ("a_hindi", ["hi"], offered),
        ("b_blind", ["en"], []),
        ("c_open", ["en"], offered),
    ):
        world.info.splits.add(name=name, episodes=dict.fromkeys(languages, 9), sensors=sensors)
    world.info.splits[0].hidden = hidden
    world.order = world.order[:2]
    real = ["--agent", "cli_agents", "--lang", "en", "--server", address, "--split", "val_seen", "--parallel", "3"]
    assert main([*real, "--sensors", "pose", "--dry-run"]) == 0
    assert world.run.split == ("c_open" if hidden else "val_seen")
    assert (world.requests[0].episodes, list(world.run.sensors), world.opens[0].max_episodes) == (2, ["pose"], 3)
    shown = capsys.readouterr()
    assert "this was a dry run: no errors" in shown.err
    assert [path.name for path in Path("arramon-results").iterdir()] == ["dry-run"]
    assert [path.name for path in Path("arramon-results/dry-run").iterdir()] == [f"{RUN}.json"]


@pytest.mark.parametrize(("asked", "named", "number"), [
    (["--episodes", "1"], [], 1), (["--episodes", "3"], [], 2), (["--episode", "e3"], ["e3"], 0),
    (["--episode", "e3", "--episode", "e1", "--episode", "e0"], ["e3", "e1"], 0),
])  # fmt: skip
def test_a_dry_run_plays_no_more_than_requested(
    world: World, address: str, asked: list[str], named: list[str], number: int
) -> None:
    assert main(["--agent", "cli_agents", "--lang", "en", "--server", address, "--dry-run", *asked]) == 0
    assert (list(world.requests[0].episode_ids), world.requests[0].episodes) == (named, number)


def test_dry_run_of_a_failing_agent_shows_its_error(
    world: World, address: str, capsys: pytest.CaptureFixture[str]
) -> None:
    world.order = world.order[:2]
    assert main(["--agent", "cli_agents:Failing", "--lang", "en", "--server", address, "--dry-run"]) == 3
    shown = capsys.readouterr().err
    assert 'if observations[0].step == 2: raise ValueError("no weights")' in shown
    assert "this was a dry run: fix the agent before the real run" in shown
    assert "--resume" not in shown
    assert world.current_run().state == pb.RUN_STATE_COMPLETE


@pytest.mark.usefixtures("interruptible")
def test_an_interrupted_dry_run_is_cancelled(world: World, address: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--agent", "cli_agents:Interrupting", "--lang", "en", "--server", address, "--dry-run"]) == 130
    assert "--resume" not in capsys.readouterr().err
    assert world.cancelled == [RUN]


def test_a_dry_run_needs_an_open_split(world: World, address: str, capsys: pytest.CaptureFixture[str]) -> None:
    world.info.splits[0].hidden = True
    assert main(["--agent", "cli_agents", "--lang", "en", "--server", address, "--dry-run"]) == 2
    assert "error: the server has no open split in 'en', and" in capsys.readouterr().err
    assert world.run.run_id == ""


def test_with_keep_going_a_failing_agent_plays_to_the_end(
    world: World, address: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["--agent", "cli_agents:Failing", "--lang", "en", "--server", address, "--keep-going"]) == 3
    shown = capsys.readouterr()
    assert "nDTW" in shown.out
    assert "the agent failed 1 time(s); 4 episode(s) were given up. First failure:" in shown.err
    assert 'if observations[0].step == 2: raise ValueError("no weights")' in shown.err
    assert "arramon_client/" not in shown.err
    failures = json.loads(Path(f"arramon-results/{RUN}.json").read_text())["agent_failures"]
    assert failures[0]["message"] == "act() raised ValueError: no weights"


@pytest.mark.parametrize(("arguments", "status", "said"), [
    (["--agent", "cli_agents", "--lang", "fr"], 2, "error: the server has no language 'fr'; it has en"),
    (["--agent", "cli_agents", "--lang", "en", "--split", "v"], 2, "the server has no split 'v'; it has val_seen"),
    (["--agent", "cli_agents", "--lang", "en", "--sensors", "oracle"], 2, "does not offer the sensor oracle"),
    (["--agent", "cli_agents", "--lang", "en", "--image-size", "99"], 2, "does not offer images of 99 pixels"),
    (["--agent", "cli_agents", "--lang", "en", "--encoding", "jpeg"], 2, "does not offer the encoding 'jpeg'"),
    (["--agent", "cli_agents", "--lang", "en", "--quality", "75"], 2, "--quality requires --encoding jpeg"),
    (["--agent", "cli_agents", "--lang", "en", "--quality", "101"], 2, "'101' is not a whole number from 1 to 100"),
    (["--agent", "cli_agents", "--lang", "en", "--quality", "0"], 2, "'0' is not a whole number from 1 to 100"),
    (["--agent", "cli_agents", "--lang", "en", "--parallel", "99"], 2, "at most 32 parallel episodes"),
    (["--agent", "cli_agent", "--lang", "en"], 2, "there is no module cli_agent installed"),
    (["--agent", "cli_agents", "--lang", "en", "--output", "cli_agents.py"], 1, "cannot be written to cli_agents.py"),
    (["--agent", "cli_agents", "--resume", OTHER, "--dry-run"], 2, "cannot be used together with --resume"),
    (["--agent", "cli_agents", "--resume", "../run"], 2, "'../run' is not the id of a run, expected 32"),
    (["--agent", "cli_agents", "--resume", OTHER], 1, f"there is no run {OTHER!r} (NOT_FOUND)"),
    (["--agent", "cli_agents"], 2, "--lang is required"),
    (["--agent", "cli_agents", "--lang", "en", "--episodes", "0"], 2, "'0' is not a whole number above 0"),
    (["--agent", "cli_agents", "--lang", "en", "--sensors", "nose"], 2, "unknown sensor 'nose', expected some of rgb"),
    (["--agent", "cli_agents", "--lang", "en", "--data", "x"], 2, "cannot be used together with --server"),
    (["--lang", "en"], 2, "required: --agent"),
    (["--agent", "cli_agents", "--lang", "en", "--agent-arg", "beam"], 2, "--agent-arg 'beam' is not NAME=VALUE"),
    (["--agent", "cli_agents", "--lang", "en", "--agent-arg", "a=1", "--agent-arg", "a=2"], 2, "a is given twice"),
    (["--agent", "cli_agents", "--lang", "en", "--agent-arg", "beam=4"], 2, "Agent() has no argument 'beam'"),
    (["--agent", "cli_agents:Taking", "--lang", "en"], 2, "Taking() requires the argument 'checkpoint'"),
    (["--agent", "cli_agents", "--lang", "en", "--episode", "e1", "--episodes", "2"], 2, "cannot be used together"),
    (["--agent", "cli_agents", "--lang", "en", "--episode", "e1", "--episode", "e1"], 2, "e1 is given twice"),
    (["--agent", "cli_agents", "--lang", "en", "--split", "dark", "--episode", "e1"], 2,
     "error: split 'dark' is hidden and must be played whole; --episode requires an open split"),
])  # fmt: skip
def test_errors_are_reported_before_a_run_is_created(
    world: World, address: str, capsys: pytest.CaptureFixture[str], arguments: list[str], status: int, said: str
) -> None:
    if "dark" in arguments:
        world.info.splits.add(name="dark", hidden=True, episodes={"en": 4}, sensors=["rgb"])
    assert main([*arguments, "--server", address]) == status
    shown = capsys.readouterr().err
    assert said in shown
    assert "Traceback" not in shown
    assert "--resume run" not in shown
    assert world.run.run_id == ""


TAKING = ["--agent", "cli_agents:Taking", "--lang", "en", "--agent-arg", "checkpoint=my w.pt", "--agent-arg", "beam=4"]


def test_arguments_and_episodes_reach_agent_and_server(world: World, address: str) -> None:
    world.order = ["e2", "e0"]
    assert main([*TAKING, "--server", address, "--episode", "e2", "--episode", "e0"]) == 0
    asked = world.requests[0]
    assert [(each.name, each.value) for each in asked.agent_arguments] == [("checkpoint", "my w.pt"), ("beam", "4")]
    assert (list(asked.episode_ids), asked.episodes) == (["e2", "e0"], 0)
    run = json.loads(Path(f"arramon-results/{RUN}.json").read_text())["run"]
    assert run["agent_arguments"] == [{"name": "checkpoint", "value": "my w.pt"}, {"name": "beam", "value": "4"}]


def test_a_run_is_resumed_only_with_its_arguments(
    world: World, address: str, capsys: pytest.CaptureFixture[str]
) -> None:
    request = pb.CreateRunRequest(agent="cli_agents:Taking", split="val_seen", language="en")
    request.agent_arguments.add(name="beam", value="4")
    request.agent_arguments.add(name="checkpoint", value="my w.pt")
    world.create(request)
    command = ["--resume", RUN, "--server", address]
    assert main([*TAKING[:-2], *command]) == 2
    begun = "--agent-arg beam=4 --agent-arg 'checkpoint=my w.pt'"
    assert f"started with {begun}, not with --agent-arg 'checkpoint=my w.pt'" in capsys.readouterr().err
    assert world.actions == {}
    assert main([*TAKING, *command]) == 0


CODED = ["--code-url", "https://example.org/a", "--code-commit", "C" * 40, "--code-image", "sha256:" + "d" * 64]


def test_the_agents_code_is_named_and_kept_when_resuming(
    world: World, address: str, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["--agent", "cli_agents", "--lang", "en", "--server", address]
    assert main([*command, *CODED]) == 0
    code = pb.Code(url="https://example.org/a", commit="c" * 40, image="sha256:" + "d" * 64)
    assert world.requests[0].code == code
    assert main([*command, *CODED[:-2], "--resume", RUN]) == 2
    assert "was started with other code" in capsys.readouterr().err
    assert main([*command, *CODED, "--resume", RUN]) == 0
    assert main([*command, "--resume", RUN]) == 0


def test_without_options_no_code_is_named(world: World, address: str) -> None:
    assert main(["--agent", "cli_agents", "--lang", "en", "--server", address]) == 0
    assert not world.requests[0].HasField("code")


def test_unreachable_server_is_reported(tmp_path: Path, address: str, capsys: pytest.CaptureFixture[str]) -> None:
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


@pytest.mark.usefixtures("interruptible")
def test_an_interrupt_prints_the_resume_command_which_completes_the_run(
    world: World, address: str, capsys: pytest.CaptureFixture[str]
) -> None:
    begun = ["--agent", "cli_agents:Interrupting", "--lang", "en", "--server", address]
    assert main(begun) == 130
    shown = capsys.readouterr().err
    command = f"arramon-client --agent cli_agents:Interrupting --lang en --server {address} --resume {RUN}"
    assert f"interrupted\nthe run is saved; resume it with\n  {command}\n" in shown
    assert world.causes == {}
    world.run.agent = "cli_agents"
    assert main(["--agent", "cli_agents", "--server", address, "--resume", RUN]) == 0
    assert world.actions == {f"e{i}": [(i + step) % 4 for step in range(5)] for i in range(4)}
    assert world.opens[-1].adopt


def test_resuming_a_complete_run_only_reports_it(
    world: World, address: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["--agent", "cli_agents", "--lang", "en", "--server", address]) == 0
    assert main(["--agent", "cli_agents", "--server", address, "--resume", RUN]) == 0
    assert len(world.opens) == 1
    assert capsys.readouterr().out.count("nDTW") == 2


def test_a_resumed_run_waits_for_an_unreachable_server(
    world: World, address: str, capsys: pytest.CaptureFixture[str]
) -> None:
    world.create(pb.CreateRunRequest(agent="cli_agents", split="val_seen", language="en"))
    world.away.update({"GetServerInfo": 2, "GetRun": 2})
    assert main(["--agent", "cli_agents", "--server", address, "--resume", RUN]) == 0
    shown = capsys.readouterr()
    assert shown.err.count(f"no connection yet (no server answers at {address}") == 1
    assert "nDTW" in shown.out


def test_a_new_run_fails_at_once_if_the_server_is_unreachable(
    world: World, address: str, capsys: pytest.CaptureFixture[str]
) -> None:
    world.away["GetServerInfo"] = 1
    assert main(["--agent", "cli_agents", "--lang", "en", "--server", address]) == 1
    assert f"error: no server answers at {address}" in capsys.readouterr().err


def test_an_encryption_error_is_not_retried(world: World, address: str, capsys: pytest.CaptureFixture[str]) -> None:
    world.create(pb.CreateRunRequest(agent="cli_agents", split="val_seen", language="en"))
    assert main(["--agent", "cli_agents", "--server", address, "--tls", "--resume", RUN]) == 1
    assert "it does not use TLS" in capsys.readouterr().err


@pytest.mark.parametrize(("changed", "said"), [
    (["--agent", "cli_agents:Failing"], "started with --agent cli_agents, not cli_agents:Failing"),
    (["--agent", "cli_agents", "--lang", "hi"], "started with --lang en, not hi"),
    (["--agent", "cli_agents", "--split", "train"], "started with --split val_seen, not train"),
])  # fmt: skip
def test_a_run_is_resumed_only_with_its_settings(
    world: World, address: str, capsys: pytest.CaptureFixture[str], changed: list[str], said: str
) -> None:
    world.create(pb.CreateRunRequest(agent="cli_agents", split="val_seen", language="en"))
    assert main([*changed, "--server", address, "--resume", RUN]) == 2
    assert said in capsys.readouterr().err


@pytest.mark.parametrize(("argv", "command"), [
    (["--agent", "a", "--lang", "en"], "arramon-client --agent a --lang en --resume r"),
    (["--agent", "a", "--resume", "q"], "arramon-client --agent a --resume r"),
    (["--resume=q", "--agent", "my agent"], "arramon-client --agent 'my agent' --resume r"),
])  # fmt: skip
def test_resume_command_keeps_the_arguments_and_names_the_run(argv: list[str], command: str) -> None:
    assert resume_command(argv, "r") == command


@pytest.mark.parametrize(("argv", "kept"), [
    (["--agent-arg", "max_calls=20"], "--agent-arg max_calls=HIGHER"),
    (["--agent-arg=max_calls=20"], "--agent-arg=max_calls=HIGHER"),
    (["--agent-arg", "max_cost=2", "--agent-arg", "x=max_calls=3"], "--agent-arg max_cost=2 --agent-arg x=max_calls=3"),
])  # fmt: skip
def test_resume_command_asks_for_a_higher_limit(argv: list[str], kept: str) -> None:
    assert resume_command(argv, "r", "max_calls") == f"arramon-client {kept} --resume r"


@pytest.mark.usefixtures("interruptible")
def test_the_module_runs_as_a_program_and_handles_a_real_interrupt(world: World, address: str, tmp_path: Path) -> None:
    (tmp_path / "slow.py").write_text(
        "import time\nclass Agent:\n"
        "    def begin(self, e): print('begun', flush=True)\n    def act(self, o): time.sleep(600)"
    )
    arguments = ["--agent", "slow", "--lang", "en", "--server", address, "--parallel", "1"]
    program = [sys.executable, "-m", "arramon_client", *arguments]
    with subprocess.Popen(program, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as client:
        assert client.stdout is not None
        assert client.stdout.readline() == "begun\n"
        os.kill(client.pid, signal.SIGINT)
        _, errors = client.communicate(timeout=120)
    assert client.returncode == 130
    assert f"--resume {RUN}" in errors
    assert "Traceback" not in errors


@pytest.mark.parametrize(("argv", "said"), [
    (["leaderbord"], "arramon-client: unknown command 'leaderbord'; did you mean 'leaderboard'?\n"),
    (["veryfy", "x.json"], "arramon-client: unknown command 'veryfy'; did you mean 'verify'?\n"),
    (["walk"], "arramon-client: unknown command 'walk'; expected account, cancel, conformance, "),
    (["--server", "x:1", "leaderboard"], "the command comes first: arramon-client leaderboard ..."),
    (["--server", "x:1", "verify", "r.json", "--key", "k"], "the command comes first: arramon-client verify ..."),
    (["--lang", "en", "--output", "runs"], "the following arguments are required: --agent"),
    (["--agent", "a", "--lang", "en", "--epsiodes", "3"],
     "unrecognized arguments: --epsiodes 3; did you mean '--episodes'?"),
    (["runs", "--sever", "x"], "unrecognized arguments: --sever x; did you mean '--server'?"),
    (["--agent", "a", "--lang", "en,"], "'en,' is not a list of different languages, such as en,hi"),
    (["--agent", "a", "--lang", "en,en"], "'en,en' is not a list of different languages"),
    (["--agent", "a", "--lang", "en", "--resume", f"{RUN},{OTHER}"], "--resume names 2 runs, more than --lang names"),
    (["--agent", "a", "--resume", f"{RUN},{RUN}"], "names a run twice"),
])  # fmt: skip
def test_what_is_misspelled_is_named_with_the_nearest(
    capsys: pytest.CaptureFixture[str], argv: list[str], said: str
) -> None:
    assert main(argv) == 2
    shown = capsys.readouterr()
    assert (shown.out, said in shown.err) == ("", True), shown.err


def test_values_of_options_are_no_commands(world: World, address: str) -> None:
    assert main(["--agent=cli_agents", "--lang", "en", f"--server={address}", "--output", "runs"]) == 0
    assert Path(f"runs/{RUN}.json").exists()


@pytest.mark.parametrize("buffered", [True, False])
def test_json_comes_alone_where_output_is_buffered(address: str, tmp_path: Path, *, buffered: bool) -> None:
    """As it is in a pipe: by the agent's own reference to standard output, too, which bypasses `sys.stdout`."""
    (tmp_path / "talking.py").write_text(AGENTS + "import sys\nprint('kept', file=sys.__stdout__)\n")
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"}
    command = [sys.executable, "-m", "arramon_client", "--agent", "talking.py", "--lang", "en", "--server", address]
    done = subprocess.run(
        [*command, "--json"], cwd=tmp_path, env=environment if buffered else {**environment, "PYTHONUNBUFFERED": "1"},
        capture_output=True, text=True, timeout=120, check=True,
    )  # fmt: skip
    assert json.loads(done.stdout)["run"]["run_id"] == RUN
    assert "kept" in done.stderr


def test_json_is_all_that_is_printed(world: World, address: str, capfd: pytest.CaptureFixture[str]) -> None:
    """Also where the agent prints, and programs that it starts."""
    Path("talking.py").write_text(AGENTS + "os.system('echo from a program')\nprint('from Python')\n")
    assert main(["--agent", "talking.py", "--lang", "en", "--server", address, "--json", "--record", "rec"]) == 0
    shown = capfd.readouterr()
    content = json.loads(shown.out)
    assert content["run"]["run_id"] == RUN
    assert content["metrics"]["total"]["nDTW"]["mean"] == 0.25
    assert content["files"] == {"results": f"arramon-results/{RUN}.json", "recording": f"rec/{RUN}/index.html"}
    assert "from a program" in shown.err
    assert "from Python" in shown.err
    assert "20 steps in" in shown.err


def test_with_json_errors_are_on_standard_error(address: str, capfd: pytest.CaptureFixture[str]) -> None:
    assert main(["--agent", "cli_agents", "--lang", "fr", "--server", address, "--json"]) == 2
    shown = capfd.readouterr()
    assert (shown.out, "error: the server has no language 'fr'" in shown.err) == ("", True)


def test_a_file_is_named_without_its_folder(world: World, address: str, tmp_path: Path) -> None:
    """The agent's name is public with the run."""
    assert main(["--agent", str(tmp_path / "cli_agents.py"), "--lang", "en", "--server", address]) == 0
    assert world.run.agent == "cli_agents"
    assert main(["--agent", "cli_agents", "--server", address, "--resume", RUN]) == 0


def test_a_dry_run_is_marked_in_its_agents_name(world: World, address: str, capsys: pytest.CaptureFixture[str]) -> None:
    world.order = world.order[:2]
    assert main(["--agent", "cli_agents", "--lang", "en", "--server", address, "--dry-run"]) == 0
    assert world.run.agent == "cli_agents (dry run)"
    assert f"dry run {RUN}: cli_agents plays 2 episodes" in capsys.readouterr().err
    assert main(["runs", "--server", address, "--agent", "cli_agents"]) == 0
    _, line = capsys.readouterr().out.splitlines()
    assert (line.split()[2], line.endswith("  dry run")) == ("cli_agents", True)
    assert main(["runs", "--server", address, "--json"]) == 0
    (listed,) = json.loads(capsys.readouterr().out)
    assert (listed["agent"], listed["dry_run"]) == ("cli_agents", True)
