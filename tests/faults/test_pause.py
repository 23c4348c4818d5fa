"""A paused process that lost its episodes to another one: it cannot write after it resumes."""

import signal
from pathlib import Path

import pytest

from tests import tiny
from tests.faults.clients import (
    EPISODES,
    UndisturbedRun,
    check_same,
    client,
    finish,
    pause,
    played_on,
    results,
    run_id,
)
from tests.relay import Relay
from tests.serving import Server


@pytest.mark.slow
def test_paused_process_cannot_write_episodes_taken_over(
    tmp_path: Path, database_url: str, undisturbed_run: UndisturbedRun
) -> None:
    tiny.write(tmp_path / "data", count=EPISODES)
    url, file = database_url, tmp_path / "journal.db" if database_url.startswith("sqlite") else None
    servers = [Server(tmp_path / "data", "127.0.0.1:0", "--journal", url, log=tmp_path / n) for n in ("one", "other")]
    with Relay(servers[0].address) as relay:
        process = client(relay.address, tmp_path / "again")
        run = run_id(process)
        recorded = played_on(url, run, 20)
        for paused, awake in (servers, servers[::-1]):
            pause(paused.process.pid, file)
            relay.target = awake.address
            relay.reset()
            recorded = played_on(url, run, recorded)
            paused.process.send_signal(signal.SIGCONT)
            recorded = played_on(url, run, recorded)
        finish(process)
    check_same(url, undisturbed_run, results(tmp_path / "again"))
    assert [server.stop() for server in servers] == [0, 0]
