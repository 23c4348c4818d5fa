"""A client connects twice at once: its first stream still stands, and plays on, when its second one is there."""

import random
import signal
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, closing
from pathlib import Path

import grpc
import pytest

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1.evaluation_pb2_grpc import EvaluationStub
from server.runs.database import Database
from server.runs.journal import Journal
from tests import tiny
from tests.api.player import Player, create
from tests.faults.clients import check_same, client, finish, journal_url, played_on, results, run_id, undisturbed
from tests.relay import Relay
from tests.serving import METADATA, Server

EPISODES = 6

SENT_AWAY = (grpc.StatusCode.FAILED_PRECONDITION, grpc.StatusCode.ABORTED)
"""How a stream ends whose player has another one: in the same process, and in another one."""


@pytest.fixture(params=[1, 2], ids=["one process", "two processes"])
def servers(request: pytest.FixtureRequest, database_url: str, tmp_path: Path) -> Iterator[list[Server]]:
    tiny.write(tmp_path / "data", count=EPISODES)
    servers = [
        Server(tmp_path / "data", "127.0.0.1:0", "--journal", database_url, log=tmp_path / f"log-{number}")
        for number in range(request.param)
    ]
    yield servers
    assert {server.stop() for server in servers} == {0}


def keep_playing(stub: EvaluationStub, run: pb.Run, over: threading.Event, chance: random.Random) -> int:
    """Plays the ground truth under the one name; who is sent away connects again. Returns how many streams it took."""
    streams = 0
    while not over.is_set():
        streams += 1
        with Player(stub, run.run_id, EPISODES, player="the same") as player:
            try:
                if player.play(tiny.ACTIONS)[-1].HasField("run_ended"):
                    over.set()
            except grpc.RpcError as error:
                if error.code() not in SENT_AWAY:
                    raise
        over.wait(chance.uniform(0.0, 0.1))
    return streams


@pytest.mark.slow
def test_both_streams_of_one_player_play_at_once_and_every_step_is_taken_once(
    servers: list[Server], database_url: str
) -> None:
    over = threading.Event()
    with ExitStack() as stack:
        pool = stack.enter_context(ThreadPoolExecutor())
        stubs = [
            EvaluationStub(stack.enter_context(grpc.insecure_channel(server.address)))
            for server in (servers[0], servers[-1])
        ]
        run = create(stubs[0])
        playing = [pool.submit(keep_playing, stub, run, over, random.Random(n)) for n, stub in enumerate(stubs)]
        assert sum(each.result(timeout=120) for each in playing) > 2
        report = stubs[0].GetReport(pb.GetReportRequest(run_id=run.run_id), metadata=METADATA)
    assert report.run.state == pb.RUN_STATE_COMPLETE
    assert {score.mean for row in report.rows for score in row.scores} == {1.0}
    with closing(Database(database_url)) as database:
        journal = Journal(database)
        actions = {each.episode_id: journal.actions(run.run_id, each.episode_id) for each in report.episodes}
    assert actions == {each.episode_id: list(tiny.ACTIONS) for each in report.episodes}


@pytest.mark.slow
def test_two_clients_play_one_run(server: Server, tmp_path: Path) -> None:
    """Whose connections break in turn, so that each takes over what the other had."""
    once = undisturbed(server, tmp_path / "once")
    url = journal_url(server.data)
    with Relay(server.address) as first_way, Relay(server.address) as second_way:
        first = client(first_way.address, tmp_path / "first")
        run = run_id(first)
        recorded = played_on(url, run, 0)
        first.send_signal(signal.SIGSTOP)  # or the run might be over before the second one has started
        second = client(second_way.address, tmp_path / "second", "--resume", run)
        assert run_id(second) == run
        first.send_signal(signal.SIGCONT)
        for way in (first_way, second_way, first_way):
            recorded = played_on(url, run, recorded)
            way.reset()
        for process in (first, second):
            finish(process)
    for output in ("first", "second"):
        check_same(url, once, results(tmp_path / output))
