"""One server on tiny splits for all tests of the service."""

from collections.abc import Iterator

import grpc
import pytest

from arramon.v1.evaluation_pb2_grpc import EvaluationStub
from arramon.v1.leaderboard_pb2_grpc import LeaderboardStub
from tests import tiny
from tests.serving import Server


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    data = tmp_path_factory.mktemp("data")
    tiny.write(data)
    tiny.write(data, "secret", 3, hidden=True)
    server = Server(data, "127.0.0.1:0", "--steps", "8")
    yield server
    assert server.stop() == 0


@pytest.fixture(scope="module")
def closed(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    """A server on which nobody plays without a token."""
    data = tmp_path_factory.mktemp("data")
    tiny.write(data)
    server = Server(data, "127.0.0.1:0", "--steps", "8", "--no-anonymous", "--runs-at-once", "0")
    yield server
    assert server.stop() == 0


@pytest.fixture
def stub(server: Server) -> Iterator[EvaluationStub]:
    with grpc.insecure_channel(server.address) as channel:
        yield EvaluationStub(channel)


@pytest.fixture
def board(server: Server) -> Iterator[LeaderboardStub]:
    with grpc.insecure_channel(server.address) as channel:
        yield LeaderboardStub(channel)
