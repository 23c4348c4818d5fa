"""Draining after a termination signal: no new work, and streams continue on another process."""

import asyncio
import os
import signal
import urllib.error
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from queue import SimpleQueue

import grpc
import pytest
from grpc_health.v1 import health_pb2, health_pb2_grpc

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1.evaluation_pb2_grpc import EvaluationStub
from tests import tiny
from tests.api.player import Player, create
from tests.faults.clients import (
    EPISODES,
    UndisturbedRun,
    check_same,
    client,
    finish,
    journal_url,
    played_on,
    results,
    run_id,
)
from tests.faults.conftest import no_client_left  # noqa: F401 - in use wherever it is imported
from tests.process.test_workers import addresses, children, listens_at
from tests.serving import METADATA, Server
from tests.web.play.page_client import PageServer, page

SERVING, NOT_SERVING = health_pb2.HealthCheckResponse.SERVING, health_pb2.HealthCheckResponse.NOT_SERVING

LINUX = pytest.mark.skipif(
    not Path("/proc/self/task").exists(), reason="finds the workers through /proc, which Linux alone has"
)


@pytest.fixture
def workers(tmp_path: Path) -> Iterator[Server]:
    tiny.write(tmp_path / "data", count=EPISODES)
    server = Server(tmp_path / "data", "127.0.0.1:0", "--workers", "2")
    yield server
    assert server.stop() == 0


@LINUX
def test_draining_moves_a_run_to_the_other_process_with_equal_scores(
    workers: Server, tmp_path: Path, undisturbed_run: UndisturbedRun
) -> None:
    process = client(workers.address, tmp_path / "moved")
    run = run_id(process)
    played_on(journal_url(workers.data), run, EPISODES)
    os.kill(children(workers.process.pid)[0], signal.SIGTERM)  # the client has a stream to each of the two
    said = finish(process)
    check_same(journal_url(workers.data), undisturbed_run, results(tmp_path / "moved"))
    for word in ("lost", "again", "shut", "UNAVAILABLE", "error", "Traceback"):
        assert word not in said, said


@LINUX
def test_draining_closes_streams_and_frees_their_episodes_at_once(workers: Server) -> None:
    first, second = addresses(workers)
    with grpc.insecure_channel(first) as channel:
        stub = EvaluationStub(channel)
        run = create(stub)
        with Player(stub, run.run_id, player="one") as player:
            episode_id = player.observation().episode_id
            player.act(episode_id, 0, tiny.ACTIONS[0])
            assert player.observation().step == 1
            (worker,) = (each for each in children(workers.process.pid) if listens_at(each, first))
            os.kill(worker, signal.SIGTERM)
            with pytest.raises(StopIteration):
                player.next()
            assert player.call.code() == grpc.StatusCode.OK
    with (
        grpc.insecure_channel(second) as channel,
        # Another player, who would have to wait for an episode that is not free.
        Player(EvaluationStub(channel), run.run_id, player="another", adopt=True) as player,
    ):
        seen = player.observation()
        assert (seen.episode_id, seen.step) == (episode_id, 0)
        assert player.observation().step == 1


def test_a_stream_that_opens_while_the_process_drains_ends_like_the_others(tmp_path: Path) -> None:
    tiny.write(tmp_path)
    server = Server(tmp_path, "127.0.0.1:0", "--drain-seconds", "3600")
    with grpc.insecure_channel(server.address) as channel:
        stub = EvaluationStub(channel)
        run = create(stub)
        first_message: SimpleQueue[pb.PlayRequest | None] = SimpleQueue()
        late = stub.Play(iter(first_message.get, None), metadata=METADATA, timeout=240)
        with Player(stub, run.run_id) as player:  # The server has accepted the late stream before this one.
            player.observation()
            server.process.send_signal(signal.SIGTERM)
            with pytest.raises(StopIteration):  # From here on the process drains.
                player.next()
        first_message.put(pb.PlayRequest(open=pb.Open(run_id=run.run_id, max_episodes=1)))
        assert list(late) == []
        assert late.code() == grpc.StatusCode.OK
        first_message.put(None)
    assert server.wait() == 0


def test_a_play_page_that_opens_while_the_process_drains_is_closed_without_an_error(tmp_path: Path) -> None:
    server = PageServer(tmp_path, "--drain-seconds", "3600")

    async def reach_draining_process() -> None:
        async with page(server.site) as late, page(server.site) as early:
            await early.hello()
            await early.until("state")
            server.process.send_signal(signal.SIGTERM)
            while not await early.is_closed():  # The frame is still to come. From here on the process drains.
                pass
            await late.hello()
            assert await late.is_closed()

    with grpc.insecure_channel(server.address) as channel:  # A call that holds the process until the page has closed.
        states = health_pb2_grpc.HealthStub(channel).Watch(health_pb2.HealthCheckRequest())
        assert next(states).status == SERVING
        asyncio.run(reach_draining_process())
        states.cancel()
        assert server.wait() == 0


class Held:
    """A server with a call that does not end by itself: a watch of its health."""

    def __init__(self, data: Path, drain_seconds: str) -> None:
        tiny.write(data)
        self.server = Server(data, "127.0.0.1:0", "--web", "127.0.0.1:0", "--drain-seconds", drain_seconds, anew=True)
        (self.web,) = (line.split()[-1] for line in self.server.said if line.startswith("pages at "))
        self.channel = grpc.insecure_channel(self.server.address)
        watch = health_pb2_grpc.HealthStub(self.channel).Watch(health_pb2.HealthCheckRequest())
        self.states = (answer.status for answer in watch)
        assert next(self.states) == SERVING

    def get(self, path: str) -> tuple[int, str]:
        try:
            with urllib.request.urlopen(self.web + path, timeout=120) as response:
                return response.status, response.read().decode()
        except urllib.error.HTTPError as error:
            with error:
                return error.code, error.read().decode()

    def terminate(self) -> None:
        self.server.process.send_signal(signal.SIGTERM)

    def wait(self) -> int:
        status = self.server.wait(240)
        self.channel.close()
        return status


def test_draining_is_announced_and_ended_by_a_second_signal(tmp_path: Path) -> None:
    held = Held(tmp_path, "3600")
    assert held.get("/readyz") == (200, "ready\n")
    held.terminate()
    assert next(held.states) == NOT_SERVING
    assert held.get("/readyz") == (503, "the server is draining\n")
    assert held.get("/healthz") == (200, "alive\n")
    held.terminate()
    assert held.wait() == 0


def test_draining_ends_at_its_time_limit(tmp_path: Path) -> None:
    held = Held(tmp_path, "0.5")
    held.terminate()
    assert held.wait() == 0
