"""Nothing is lost: whoever is killed again and again, a run ends with the scores of an undisturbed one."""

import json
import random
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from server.runs.database import Database
from server.runs.journal import Journal
from tests import tiny
from tests.serving import Server

EPISODES = 20
KILLS = 10


@pytest.fixture
def server(tmp_path: Path) -> Iterator[Server]:
    tiny.write(tmp_path / "data", count=EPISODES)
    server = Server(tmp_path / "data", "127.0.0.1:0")
    yield server
    assert server.stop() == 0


def client(server: Server, output: Path, *more: str) -> "subprocess.Popen[str]":
    command = [sys.executable, "-m", "arramon_client", "--agent", "agents.random_walk", "--lang", "en"]
    command += ["--server", server.address, "--parallel", str(EPISODES), "--sensors", "none", "--output", str(output)]
    return subprocess.Popen([*command, *more], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)


def finish(process: "subprocess.Popen[str]") -> str:
    said, _ = process.communicate(timeout=120)
    assert process.returncode == 0, said
    return said


def results(output: Path) -> Any:
    (path,) = output.glob("*.json")
    return json.loads(path.read_text())


def run_id(process: "subprocess.Popen[str]") -> str:
    assert process.stdout is not None
    for line in process.stdout:
        if line.startswith("run "):
            return line.split()[1].rstrip(":")
    raise AssertionError("the client said nothing of a run")


def played_on(server: Server, run: str, recorded: int) -> int:
    """Waits until more than `recorded` steps of the run are in the journal; returns how many."""
    with closing(Database(f"sqlite:///{server.data / 'journal.db'}")) as database:
        journal = Journal(database)
        for _ in range(1000):
            progress = journal.progress(run)
            assert progress.ended < progress.episodes, "the run was over before the last kill"
            if progress.steps > recorded:
                return progress.steps
            time.sleep(0.02)
    raise AssertionError(f"no step after {recorded} in 20 seconds")


def check_same(server: Server, undisturbed: Any, disturbed: Any) -> None:
    assert disturbed["episodes"] == undisturbed["episodes"]
    assert disturbed["table"] == undisturbed["table"]
    with closing(Database(f"sqlite:///{server.data / 'journal.db'}")) as database:
        journal = Journal(database)
        once, again = (
            {e["episode_id"]: journal.actions(r["run"]["run_id"], e["episode_id"]) for e in r["episodes"]}
            for r in (undisturbed, disturbed)
        )
    assert once == again
    assert {e["episode_id"]: e["steps"] for e in disturbed["episodes"]} == {k: len(v) for k, v in again.items()}


@pytest.mark.slow
def test_the_server_is_killed_ten_times(server: Server, tmp_path: Path) -> None:
    finish(client(server, tmp_path / "undisturbed"))
    chance = random.Random(7)
    process = client(server, tmp_path / "disturbed")
    run = run_id(process)
    recorded = 0
    for _ in range(KILLS):
        recorded = played_on(server, run, recorded)
        time.sleep(chance.uniform(0.0, 0.2))
        server.kill()
        server.start()
    said = finish(process)
    assert "trying again" in said
    check_same(server, results(tmp_path / "undisturbed"), results(tmp_path / "disturbed"))


@pytest.mark.slow
def test_the_client_is_killed_and_resumes(server: Server, tmp_path: Path) -> None:
    finish(client(server, tmp_path / "undisturbed"))
    process = client(server, tmp_path / "disturbed")
    run = run_id(process)
    for moment in (1.2, 2.0, 2.5):
        time.sleep(moment)
        process.send_signal(signal.SIGKILL)
        process.communicate()
        process = client(server, tmp_path / "disturbed", "--resume", run)
    finish(process)
    check_same(server, results(tmp_path / "undisturbed"), results(tmp_path / "disturbed"))
