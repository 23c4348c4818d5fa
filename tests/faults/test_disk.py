"""A temporarily full disk."""

import resource
import time
from pathlib import Path

import pytest

from arramon_server.api.error_guard import STORAGE_ERROR_TEXT
from tests.faults.clients import UndisturbedRun, check_same, client, finish, journal_url, played_on, results, run_id
from tests.serving import Server

FAILURE = "the journal cannot be used"

UNLIMITED = (resource.RLIM_INFINITY, resource.RLIM_INFINITY)


@pytest.mark.slow
def test_run_survives_a_temporarily_full_disk(server: Server, tmp_path: Path, undisturbed_run: UndisturbedRun) -> None:
    """As the operating system limits the running server's files, every write beyond fails, as on a full disk."""
    assert server.log is not None
    log = server.log
    process = client(server.address, tmp_path / "again")
    run = run_id(process)
    recorded = played_on(journal_url(server.data), run, 20)
    for _ in range(3):
        failures = log.read_text().count(FAILURE)
        resource.prlimit(server.process.pid, resource.RLIMIT_FSIZE, (4096, resource.RLIM_INFINITY))
        while log.read_text().count(FAILURE) == failures:
            time.sleep(0.02)
        resource.prlimit(server.process.pid, resource.RLIMIT_FSIZE, UNLIMITED)
        recorded = played_on(journal_url(server.data), run, recorded)
    said = finish(process)
    assert STORAGE_ERROR_TEXT in said
    assert "sqlite" not in said.lower()
    check_same(journal_url(server.data), undisturbed_run, results(tmp_path / "again"))
