"""Real clients that play during faults, and the comparison of their results with an undisturbed run."""

import json
import os
import signal
import sqlite3
import subprocess
import sys
import time
from contextlib import closing
from pathlib import Path
from typing import Any, NamedTuple
from weakref import WeakSet

from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.journal import Journal
from tests.forked import ForkedClient
from tests.serving import Server

EPISODES = 20


Client = subprocess.Popen[str] | ForkedClient

STARTED: WeakSet[Client] = WeakSet()
"""The clients of this process, for whoever has to end those that are left."""


def client(address: str | None, output: Path, *more: str) -> Client:
    """`arramon-client` with an agent whose actions are drawn by episode and step, all episodes at once, no images.

    It is forked where servers are (`serving.Server.fork`). Without an address its server is an embedded one.
    """
    arguments = ["--agent", "agents.random_walk", "--lang", "en", "--parallel", str(EPISODES)]
    arguments += ["--server", address] if address else []
    arguments += ["--sensors", "none", "--output", str(output), *more]
    process: Client
    if Server.fork is not None:
        process = ForkedClient(arguments)
    else:
        command = [sys.executable, "-m", "arramon_client", *arguments]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    STARTED.add(process)
    return process


def finish(process: Client) -> str:
    """Waits until a client has played to the end; returns what it said."""
    said, _ = process.communicate(timeout=900)
    assert process.returncode == 0, said
    return said


def results(output: Path) -> Any:
    """What a client wrote down of its only run."""
    (path,) = (path for path in output.glob("*.json") if not path.name.endswith(".receipt.json"))
    return json.loads(path.read_text())


def run_id(process: Client) -> str:
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
        for _ in range(10_000):
            progress = journal.progress(run)
            assert progress.ended < progress.episodes, "the run was over before the last fault"
            if progress.steps > recorded:
                return progress.steps
            time.sleep(0.02)
    raise AssertionError(f"no step after {recorded} in 200 seconds")


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


class UndisturbedRun(NamedTuple):
    """An undisturbed run: the results of its client, and the URL of its journal."""

    results: Any
    url: str


def undisturbed(server: Server, output: Path, *more: str) -> Any:
    """Play an undisturbed run, and return its results."""
    finish(client(server.address, output, *more))
    return results(output)


def check_same(url: str, once: UndisturbedRun, again: Any) -> None:
    """A run in the journal at `url` has the scores, causes and actions of the undisturbed one."""
    assert differences(url, once.results, again, once_url=once.url) == []


def played(url: str, run: Any) -> dict[str, list[int]]:
    """The actions of a run by episode, from the journal."""
    with closing(Database(url)) as database:
        journal = Journal(database)
        return {e["episode_id"]: journal.actions(run["run"]["run_id"], e["episode_id"]) for e in run["episodes"]}


def differences(url: str, once: Any, again: Any, *, once_url: str = "") -> list[str]:
    """What is not the same in two runs, by their results and in the journal, in words.

    Args:
        url: the journal that holds both.
        once: the results of one.
        again: the results of the other.
        once_url: the first one's journal, where that is another.
    """
    first, second = played(once_url or url, once), played(url, again)
    lengths = {e["episode_id"]: e["steps"] for e in again["episodes"]}
    same = {
        "scores or causes of episodes": again["episodes"] == once["episodes"],
        "the table": again["table"] == once["table"],
        "actions": first == second,
        "numbers of steps": lengths == {episode_id: len(actions) for episode_id, actions in second.items()},
    }
    return [f"{what} differ" for what, is_same in same.items() if not is_same]
