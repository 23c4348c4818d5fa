"""Database outages during a run: it continues on its own, with the result of an undisturbed run."""

import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests import tiny
from tests.faults.clients import EPISODES, UndisturbedRun, check_same, client, finish, played_on, results, run_id
from tests.postgres import Cluster
from tests.serving import Server


@pytest.fixture(params=[1, 2], ids=["1 worker", "2 workers"])
def server(request: pytest.FixtureRequest, postgres_url: str, tmp_path: Path) -> Iterator[Server]:
    tiny.write(tmp_path / "data", count=EPISODES)
    server = Server(
        tmp_path / "data",
        "127.0.0.1:0",
        "--journal",
        postgres_url,
        "--workers",
        str(request.param),
        log=tmp_path / "log",
    )
    yield server
    assert server.stop() == 0


@pytest.mark.slow
def test_run_survives_three_database_outages(
    server: Server, cluster: Cluster, postgres_url: str, tmp_path: Path, undisturbed_run: UndisturbedRun
) -> None:
    process = client(server.address, tmp_path / "disturbed")
    run, recorded = run_id(process), 0
    for crashed, seconds in ((True, 0.0), (True, 2.5), (False, 1.0)):
        recorded = played_on(postgres_url, run, recorded)
        if crashed:
            cluster.crash()
        else:
            cluster.stop()
        time.sleep(seconds)
        cluster.start()
    said = finish(process)
    assert "retrying" in said
    check_same(postgres_url, undisturbed_run, results(tmp_path / "disturbed"))
