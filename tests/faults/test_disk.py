"""The disk is full, for a while."""

import resource
import time
from pathlib import Path

import pytest

from server.api.guard import AWAY
from tests.faults.clients import check_same, client, finish, journal_url, played_on, results, run_id, undisturbed
from tests.serving import Server

UNLIMITED = (resource.RLIM_INFINITY, resource.RLIM_INFINITY)


@pytest.mark.slow
def test_no_file_of_the_server_can_grow_for_a_while(server: Server, tmp_path: Path) -> None:
    """As the operating system limits the running server's files, every write beyond fails, as on a full disk."""
    once = undisturbed(server, tmp_path / "once")
    process = client(server.address, tmp_path / "again")
    run = run_id(process)
    recorded = played_on(journal_url(server.data), run, 20)
    for _ in range(3):
        resource.prlimit(server.process.pid, resource.RLIMIT_FSIZE, (4096, resource.RLIM_INFINITY))
        time.sleep(1.0)
        resource.prlimit(server.process.pid, resource.RLIMIT_FSIZE, UNLIMITED)
        recorded = played_on(journal_url(server.data), run, recorded)
    said = finish(process)
    assert AWAY in said
    assert "sqlite" not in said.lower()
    check_same(journal_url(server.data), once, results(tmp_path / "again"))
    assert server.log is not None
    assert "the journal cannot be used" in server.log.read_text()
