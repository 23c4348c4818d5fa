"""Real clients that play while something goes wrong, and what must be equal afterwards."""

import json
import os
import signal
import sqlite3
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


def pause(process_id: int, database: Path | None) -> None:
    """Stops a server process in its tracks.

    Not while it writes to SQLite (the file `database`), whose lock it would take along: then all others wait, and
    nothing can be done about that but PostgreSQL, which ends a transaction that stands idle.
    """
    for _ in range(200):
        os.kill(process_id, signal.SIGSTOP)
        if database is None or not is_locked(database):
            return
        os.kill(process_id, signal.SIGCONT)
        time.sleep(0.01)
    raise AssertionError("the server never let the database go")


def is_locked(database: Path) -> bool:
    with closing(sqlite3.connect(database, timeout=0.05, isolation_level=None)) as probe:
        try:
            probe.execute("BEGIN IMMEDIATE")
        except sqlite3.OperationalError:
            return True
        probe.execute("ROLLBACK")
        return False


def undisturbed(server: Server, output: Path) -> Any:
    """The results of a run in peace."""
    finish(client(server.address, output))
    return results(output)


def check_same(url: str, once: Any, again: Any) -> None:
    """Two runs have the same scores, causes and actions."""
    assert differences(url, once, again) == []


def differences(url: str, once: Any, again: Any) -> list[str]:
    """What is not the same in two runs, by their results and in the journal, in words."""
    with closing(Database(url)) as database:
        journal = Journal(database)
        played = [
            {e["episode_id"]: journal.actions(each["run"]["run_id"], e["episode_id"]) for e in each["episodes"]}
            for each in (once, again)
        ]
    lengths = {e["episode_id"]: e["steps"] for e in again["episodes"]}
    same = {
        "scores or causes of episodes": again["episodes"] == once["episodes"],
        "the table": again["table"] == once["table"],
        "actions": played[0] == played[1],
        "numbers of steps": lengths == {episode_id: len(actions) for episode_id, actions in played[1].items()},
    }
    return [f"{what} differ" for what, is_same in same.items() if not is_same]
