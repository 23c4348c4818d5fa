"""Connections between client and server that are reset or fall silent."""

import random
import time
from pathlib import Path

import pytest

from tests.faults.clients import UndisturbedRun, check_same, client, finish, journal_url, played_on, results, run_id
from tests.relay import Relay
from tests.serving import Server


@pytest.mark.slow
def test_run_survives_repeated_connection_resets(
    server: Server, tmp_path: Path, undisturbed_run: UndisturbedRun
) -> None:
    chance = random.Random(3)
    with Relay(server.address) as relay:
        process = client(relay.address, tmp_path / "again")
        run = run_id(process)
        recorded = 0
        for _ in range(12):
            recorded = played_on(journal_url(server.data), run, recorded)
            time.sleep(chance.uniform(0.0, 0.1))
            relay.reset()
        finish(process)
        assert relay.resets > 6
    check_same(journal_url(server.data), undisturbed_run, results(tmp_path / "again"))


@pytest.mark.slow
def test_another_client_resumes_after_a_half_open_connection(
    server: Server, tmp_path: Path, undisturbed_run: UndisturbedRun
) -> None:
    """Half-open: the server sees no end of the first stream. The same run, resumed, takes its episodes over."""
    with Relay(server.address) as relay:
        silent = client(relay.address, tmp_path / "silent")
        run = run_id(silent)
        recorded = played_on(journal_url(server.data), run, 20)
        relay.freeze()
        resumed = client(server.address, tmp_path / "again", "--resume", run)
        finish(resumed)
        silent.kill()
        silent.communicate()
    again = results(tmp_path / "again")
    assert again["run"]["steps"] > recorded
    check_same(journal_url(server.data), undisturbed_run, again)
