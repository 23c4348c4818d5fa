"""Hand-written HTTP/2 attacks on one connection: other clients are still answered."""

from pathlib import Path

import pytest

from tests import tiny
from tests.hostile.attacks import Attacker
from tests.hostile.conftest import memory
from tests.hostile.frames import Connection
from tests.serving import Server

INFO = "/arramon.v1.Evaluation/GetServerInfo"

RESETS = 20_000

PILE = 24
"""MiB by which the server may grow under them. Without a bound on a connection's calls they shut others out."""

FLOOD = 2_000
"""Frames, which are 32 MB."""

BUFFERS = 160
"""MiB that gRPC holds while header fields come faster than it reads them: a bound of its own, however many come."""


def answers(server: Server) -> bool:
    attacker = Attacker(server.address, seed=1)
    try:
        return attacker.unary("GetServerInfo", b"") is not None
    finally:
        attacker.close()


def test_rapidly_reset_calls_do_not_accumulate_memory(tmp_path: Path) -> None:
    tiny.write(tmp_path)
    server = Server(tmp_path, "127.0.0.1:0")
    try:
        assert answers(server)
        before = memory(server)
        connection = Connection(server.address)
        while connection.calls < RESETS and connection.reset(INFO, 100):
            pass
        assert answers(server)
        connection.close()
        assert memory(server) < before + PILE
    finally:
        assert server.stop() == 0


@pytest.mark.parametrize("kind", ["long", "short", "empty"])
def test_endless_headers_do_not_accumulate_memory(server: Server, kind: str) -> None:
    before = memory(server)
    connection = Connection(server.address)
    while connection.frames < FLOOD and connection.flood(INFO, kind, 20):
        pass
    assert answers(server)
    connection.close()
    assert memory(server) < before + BUFFERS
