"""Killed servers and clients: a run ends with the scores of an undisturbed one."""

import random
import signal
import time
from pathlib import Path

import pytest

from tests.faults.clients import UndisturbedRun, check_same, client, finish, journal_url, played_on, results, run_id
from tests.serving import Server

KILLS = 10


@pytest.mark.slow
def test_run_survives_ten_server_kills(server: Server, tmp_path: Path, undisturbed_run: UndisturbedRun) -> None:
    chance = random.Random(7)
    process = client(server.address, tmp_path / "again")
    run = run_id(process)
    recorded = 0
    for _ in range(KILLS):
        recorded = played_on(journal_url(server.data), run, recorded)
        time.sleep(chance.uniform(0.0, 0.2))  # anywhere in a step, not always where one was just written
        server.kill()
        server.start()
    assert "retrying" in finish(process)
    check_same(journal_url(server.data), undisturbed_run, results(tmp_path / "again"))


@pytest.mark.slow
def test_run_survives_client_kills_by_resuming(server: Server, tmp_path: Path, undisturbed_run: UndisturbedRun) -> None:
    process = client(server.address, tmp_path / "again")
    run = run_id(process)
    recorded = 0
    for _ in range(3):
        recorded = played_on(journal_url(server.data), run, recorded)
        process.send_signal(signal.SIGKILL)
        process.communicate()
        process = client(server.address, tmp_path / "again", "--resume", run)
    finish(process)
    check_same(journal_url(server.data), undisturbed_run, results(tmp_path / "again"))
