"""A server whose runs are disturbed."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests import tiny
from tests.faults.clients import EPISODES
from tests.serving import Server


@pytest.fixture
def server(tmp_path: Path) -> Iterator[Server]:
    tiny.write(tmp_path / "data", count=EPISODES)
    server = Server(tmp_path / "data", "127.0.0.1:0", log=tmp_path / "server.log")
    yield server
    assert server.stop() == 0
