"""A process stands still, loses its episodes to another, and wakes up in the belief that it still has them."""

import signal
import sqlite3
import time
from contextlib import closing
from pathlib import Path

import pytest

from tests import tiny
from tests.faults.clients import (
    EPISODES,
    check_same,
    client,
    finish,
    played_on,
    results,
    run_id,
    undisturbed,
)
from tests.relay import Relay
from tests.serving import Server


def pause(server: Server, database: Path | None) -> None:
    """Stops a process in its tracks.

    Not while it writes to SQLite, whose lock it would take along: then all others wait, and nothing can be done about
    that but PostgreSQL, which ends a transaction that stands idle.
    """
    for _ in range(200):
        server.process.send_signal(signal.SIGSTOP)
        if database is None or not is_locked(database):
            return
        server.process.send_signal(signal.SIGCONT)
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


@pytest.mark.slow
def test_a_paused_process_cannot_write_what_another_plays(tmp_path: Path, database_url: str) -> None:
    tiny.write(tmp_path / "data", count=EPISODES)
    url, file = database_url, tmp_path / "journal.db" if database_url.startswith("sqlite") else None
    servers = [Server(tmp_path / "data", "127.0.0.1:0", "--journal", url, log=tmp_path / n) for n in ("one", "other")]
    once = undisturbed(servers[0], tmp_path / "once")
    with Relay(servers[0].address) as relay:
        process = client(relay.address, tmp_path / "again")
        run = run_id(process)
        recorded = played_on(url, run, 20)
        for paused, awake in (servers, servers[::-1]):
            pause(paused, file)
            relay.target = awake.address
            relay.reset()
            recorded = played_on(url, run, recorded)
            paused.process.send_signal(signal.SIGCONT)
            recorded = played_on(url, run, recorded)
        finish(process)
    check_same(url, once, results(tmp_path / "again"))
    assert [server.stop() for server in servers] == [0, 0]
