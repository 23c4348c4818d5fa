"""Callers that hold many calls or streams: others are still served."""

import threading
from collections.abc import Iterator
from contextlib import ExitStack
from typing import Any

import grpc
import pytest
from grpc_health.v1 import health_pb2, health_pb2_grpc
from grpc_reflection.v1alpha import reflection_pb2_grpc

from arramon.v1 import evaluation_pb2 as pb
from tests import tiny
from tests.api.people import Person, token_of
from tests.api.player import Player, create
from tests.hostile.attacks import PATIENCE
from tests.serving import METADATA, Server

CALLS = 64
"""That the server has open at once; one of many holds a quarter of them."""

OWN = [("grpc.use_local_subchannel_pool", 1)]


@pytest.fixture(scope="module")
def public(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    """A server that strangers reach, and that has little room."""
    data = tmp_path_factory.mktemp("data")
    tiny.write(data)
    server = Server(data, "127.0.0.1:0", "--no-anonymous", "--max-calls", str(CALLS), log=data / "log")
    yield server
    assert server.stop() == 0


@pytest.fixture
def silent() -> Iterator[Any]:
    """A stream's messages that do not come, as long as the test lasts."""
    done = threading.Event()

    def nothing() -> Iterator[Any]:
        done.wait(240)
        yield from ()

    yield nothing
    done.set()


def plays(server: Server, name: str) -> bool:
    """Whether a participant gets through: information, a run, its play and its report."""
    with Person(server.address, token_of(server.data, name)) as person:
        person.stub.GetServerInfo(pb.GetServerInfoRequest(), metadata=METADATA, timeout=PATIENCE)
        run = create(person.stub, episodes=1)
        with Player(person.stub, run.run_id) as player:
            player.play(tiny.ACTIONS)
        report = person.stub.GetReport(pb.GetReportRequest(run_id=run.run_id), metadata=METADATA, timeout=PATIENCE)
    return {row.name for row in report.rows} == {"turn 1", "turn 2", "total"}


def held(stack: ExitStack, call: Any) -> Any:
    """A call that stays open until the end."""
    stack.callback(call.cancel)
    return call


@pytest.mark.parametrize("kind", ["watch", "reflection"])
def test_held_anonymous_calls_do_not_block_others(public: Server, silent: Any, kind: str) -> None:
    with ExitStack() as stack:
        channel = stack.enter_context(grpc.insecure_channel(public.address, options=OWN))
        health = health_pb2_grpc.HealthStub(channel)
        reflection = reflection_pb2_grpc.ServerReflectionStub(channel)
        for _ in range(2 * CALLS):
            watching = health.Watch(health_pb2.HealthCheckRequest()) if kind == "watch" else None
            held(stack, watching or reflection.ServerReflectionInfo(silent()))
        assert health.Check(health_pb2.HealthCheckRequest(), timeout=PATIENCE).status == 1
        assert plays(public, f"beside {kind}")


def test_held_streams_of_one_participant_do_not_block_others(public: Server, silent: Any) -> None:
    with ExitStack() as stack:
        greedy = stack.enter_context(Person(public.address, token_of(public.data, "greedy")))
        streams = [held(stack, greedy.stub.Play(silent(), metadata=METADATA)) for _ in range(2 * CALLS)]
        with pytest.raises(grpc.RpcError) as error:
            next(streams[-1])
        assert error.value.code() == grpc.StatusCode.RESOURCE_EXHAUSTED
        assert error.value.details() == (
            "too many open calls from participant greedy: 16 are allowed; try again when one has ended"
        )
        assert plays(public, "modest")
    with Person(public.address, token_of(public.data, "greedy")) as greedy:
        assert (
            greedy.stub.GetAccount(pb.GetAccountRequest(), metadata=METADATA, timeout=PATIENCE).participant == "greedy"
        )


def test_many_calls_of_one_participant_do_not_block_others(public: Server) -> None:
    with ExitStack() as stack:
        greedy = stack.enter_context(Person(public.address, token_of(public.data, "asker")))
        calls = [greedy.stub.ListRuns.future(pb.ListRunsRequest(), metadata=METADATA) for _ in range(CALLS // 4)]
        assert plays(public, "beside the asker")
        assert {call.code() for call in calls} == {grpc.StatusCode.OK}
