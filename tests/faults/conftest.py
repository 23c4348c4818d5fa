"""Fixtures of the fault tests: a server, and the removal of remaining clients."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests import tiny
from tests.faults.clients import EPISODES, STARTED
from tests.serving import Server


@pytest.fixture(autouse=True)
def no_client_left() -> Iterator[None]:
    """No client outlives the test that started it, however the test ends: its process would disturb the others."""
    yield
    for process in list(STARTED):
        if process.poll() is None:
            process.kill()
            process.communicate()
        STARTED.discard(process)


@pytest.fixture
def server(tmp_path: Path) -> Iterator[Server]:
    tiny.write(tmp_path / "data", count=EPISODES)
    server = Server(tmp_path / "data", "127.0.0.1:0", log=tmp_path / "server.log")
    yield server
    assert server.stop() == 0
