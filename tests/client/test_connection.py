"""Connections: the protocol version on every call, and error messages."""

import socket
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import grpc
import pytest

from arramon.v1 import evaluation_pb2 as pb
from arramon_client import (
    ArramonClientError,
    MessageTooLargeError,
    NotArramonError,
    RefusedError,
    ServerUnreachableError,
    VersionMismatchError,
    connect,
)
from arramon_client.transport.access import is_local
from arramon_client.transport.connection import Server, call, explain
from tests.client.fake import RUN, Servicer, World, serving


def test_every_call_carries_the_protocol_version(world: World) -> None:
    servicer = Servicer(world)
    with serving(servicer) as address, connect(address) as server:
        assert server.info.version == "9.9.9"
    assert servicer.metadata[0]["arramon-protocol"] == "1"


def test_client_connects_over_a_unix_socket(world: World, tmp_path: Path) -> None:
    with serving(Servicer(world), f"unix:{tmp_path}/s") as address, connect(address) as server:
        assert server.info.protocol == 1


def test_unreachable_server_is_reported() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        address = f"127.0.0.1:{taken.getsockname()[1]}"
        with pytest.raises(ServerUnreachableError, match=f"no server answers at {address}"), connect(address):
            pass


def test_server_of_another_kind_is_reported() -> None:
    pool = ThreadPoolExecutor(1)
    other = grpc.server(pool)
    port = other.add_insecure_port("127.0.0.1:0")
    other.start()
    try:
        with pytest.raises(NotArramonError, match="not an ArraMon server"), connect(f"127.0.0.1:{port}"):
            pass
    finally:
        other.stop(None).wait()
        pool.shutdown()


def test_protocol_refusal_is_a_version_mismatch(world: World) -> None:
    class Refusing(Servicer):
        def GetServerInfo(self, request: pb.GetServerInfoRequest, context: Any) -> pb.ServerInfo:  # noqa: N802
            context.abort(grpc.StatusCode.FAILED_PRECONDITION, "this server speaks protocol 2")
            return pb.ServerInfo()

    with (
        serving(Refusing(world)) as address,
        pytest.raises(VersionMismatchError, match="this server speaks protocol 2"),
        connect(address),
    ):
        pass


@pytest.mark.parametrize(("protocol", "older"), [(2, "upgrade this client"), (0, "upgrade the server")])
def test_version_mismatch_names_the_side_to_upgrade(world: World, protocol: int, older: str) -> None:
    world.info.protocol = protocol
    with serving(Servicer(world)) as address, pytest.raises(VersionMismatchError, match=older), connect(address):
        pass


def test_a_refusal_shows_the_servers_message(world: World) -> None:
    with serving(Servicer(world)) as address, connect(address) as server:
        with pytest.raises(RefusedError, match=r"there is no run 'x' \(NOT_FOUND\)") as caught:
            call(server.stub.GetRun, pb.GetRunRequest(run_id="x"), address)
        assert caught.value.code == grpc.StatusCode.NOT_FOUND


@pytest.mark.parametrize(
    ("method", "request_"),
    [
        ("GetServerInfo", pb.GetServerInfoRequest()),
        ("GetRun", pb.GetRunRequest(run_id=RUN)),
        ("GetReport", pb.GetReportRequest(run_id=RUN)),
    ],
)
def test_a_read_that_reaches_a_draining_process_is_repeated_once(
    world: World, server: Server, run: pb.Run, method: str, request_: Any
) -> None:
    world.draining[method] = 1
    assert call(getattr(server.stub, method), request_, server.address)
    world.draining[method] = 2
    with pytest.raises(ServerUnreachableError, match=f"the server process at {server.address} is shutting down"):
        call(getattr(server.stub, method), request_, server.address)
    assert world.draining[method] == 0


def test_connecting_to_a_draining_process_is_repeated(world: World) -> None:
    world.draining["GetServerInfo"] = 1
    with serving(Servicer(world)) as address, connect(address) as server:
        assert server.info.version == "9.9.9"


def test_a_run_that_a_draining_process_may_have_created_is_not_created_twice(world: World, server: Server) -> None:
    world.draining["CreateRun"] = 1
    request = pb.CreateRunRequest(agent="recorder", split="val_seen", language="en")
    with pytest.raises(ServerUnreachableError, match="is shutting down, and did not answer: try again"):
        call(server.stub.CreateRun, request, server.address)
    assert len(world.requests) == 1


class Failure(grpc.RpcError):
    def __init__(self, code: grpc.StatusCode, details: str) -> None:
        self._code, self._details = code, details

    def code(self) -> grpc.StatusCode:
        return self._code

    def details(self) -> str:
        return self._details


@pytest.mark.parametrize(("code", "details", "kind", "said"), [
    (grpc.StatusCode.RESOURCE_EXHAUSTED, "CLIENT: Received message larger than max (9 vs. 4)", MessageTooLargeError,
     "a smaller --parallel"),
    (grpc.StatusCode.RESOURCE_EXHAUSTED, "ten runs a day", RefusedError, "ten runs a day"),
    (grpc.StatusCode.DEADLINE_EXCEEDED, "", ServerUnreachableError, "no server answers at here"),
    (grpc.StatusCode.CANCELLED, "CANCELLED", ServerUnreachableError, "the server process at here is shutting down"),
    (grpc.StatusCode.CANCELLED, "Channel closed!", RefusedError, "Channel closed!"),
    (grpc.StatusCode.PERMISSION_DENIED, "", RefusedError, "no reason was given"),
    (grpc.StatusCode.ALREADY_EXISTS, "", RefusedError, "no reason was given"),
])  # fmt: skip
def test_grpc_statuses_map_to_client_errors(
    code: grpc.StatusCode, details: str, kind: type[ArramonClientError], said: str
) -> None:
    error = explain(Failure(code, details), "here")
    assert type(error) is kind
    assert said in str(error)


@pytest.mark.parametrize(("address", "local"), [
    ("unix:/tmp/x", True), ("localhost:50051", True), ("127.0.0.1:1", True), ("127.8.8.8:1", True), ("[::1]:5", True),
    ("dns:///localhost:1", True), ("10.0.0.1:1", False), ("arramon.example.org:443", False), ("[2001:db8::1]:1", False),
])  # fmt: skip
def test_local_addresses_are_recognised(address: str, local: bool) -> None:
    assert is_local(address) is local
