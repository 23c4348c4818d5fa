"""Real clients that play while something goes wrong, and what must be equal afterwards."""

import json
import subprocess
import sys
import time
from contextlib import closing
from pathlib import Path
from typing import Any

from server.runs.database import Database
from server.runs.journal import Journal
from tests.serving import Server

EPISODES = 20


def client(address: str, output: Path, *more: str) -> "subprocess.Popen[str]":
    """`arramon-client` with an agent whose actions are drawn by episode and step, all episodes at once, no images."""
    command = [sys.executable, "-m", "arramon_client", "--agent", "agents.random_walk", "--lang", "en"]
    command += ["--server", address, "--parallel", str(EPISODES), "--sensors", "none", "--output", str(output)]
    return subprocess.Popen([*command, *more], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)


def finish(process: "subprocess.Popen[str]") -> str:
    """Waits until a client has played to the end; returns what it said."""
    said, _ = process.communicate(timeout=240)
    assert process.returncode == 0, said
    return said


def results(output: Path) -> Any:
    """What a client wrote down of its only run."""
    (path,) = (path for path in output.glob("*.json") if not path.name.endswith(".receipt.json"))
    return json.loads(path.read_text())


def run_id(process: "subprocess.Popen[str]") -> str:
    """The run that a client has begun."""
    assert process.stdout is not None
    for line in process.stdout:
        if line.startswith("run "):
            return line.split()[1].rstrip(":")
    raise AssertionError("the client said nothing of a run")


def journal_url(data: Path) -> str:
    """Of a server that keeps it in its data folder."""
    return f"sqlite:///{data / 'journal.db'}"


def played_on(url: str, run: str, recorded: int) -> int:
    """Waits until more than `recorded` steps of the run are in the journal; returns how many."""
    with closing(Database(url)) as database:
        journal = Journal(database)
        for _ in range(3000):
            progress = journal.progress(run)
            assert progress.ended < progress.episodes, "the run was over before the last fault"
            if progress.steps > recorded:
                return progress.steps
            time.sleep(0.02)
    raise AssertionError(f"no step after {recorded} in 60 seconds")


def undisturbed(server: Server, output: Path) -> Any:
    """The results of a run in peace."""
    finish(client(server.address, output))
    return results(output)


def check_same(url: str, once: Any, again: Any) -> None:
    """Two runs have the same scores, causes and actions."""
    assert again["episodes"] == once["episodes"]
    assert again["table"] == once["table"]
    with closing(Database(url)) as database:
        journal = Journal(database)
        first, second = (
            {e["episode_id"]: journal.actions(r["run"]["run_id"], e["episode_id"]) for e in r["episodes"]}
            for r in (once, again)
        )
    assert first == second
    assert {e["episode_id"]: e["steps"] for e in again["episodes"]} == {k: len(v) for k, v in second.items()}
