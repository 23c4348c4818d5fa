"""Two simultaneous streams or clients of one run: every step is taken once."""

import random
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, closing
from functools import partial
from pathlib import Path

import grpc
import pytest

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1.evaluation_pb2_grpc import EvaluationStub
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.journal import Journal
from tests import tiny
from tests.api.player import Player, create
from tests.faults.clients import UndisturbedRun, check_same, client, finish, journal_url, played_on, results, run_id
from tests.relay import Relay
from tests.serving import METADATA, Server

EPISODES = 6

AT_MOST = 120.0
"""Seconds after which a thread is given up that never ends; nothing waits for so long on purpose."""

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


class Rivals:
    """Two clients that play one run under one name; who is sent away connects again.

    Nobody acts before both have seen an episode, and no episode is finished before one of the two was sent away: so
    their streams meet, however fast either of them is.
    """

    def __init__(self, run: pb.Run, pool: ThreadPoolExecutor) -> None:
        self._run, self._pool = run, pool
        self._seen = (threading.Event(), threading.Event())
        self._sent_away, self._over = threading.Event(), threading.Event()

    def play(self, number: int, stub: EvaluationStub) -> None:
        """Play as one of the two until the run ends."""
        chance = random.Random(number)
        while not self._over.is_set():
            with Player(stub, self._run.run_id, EPISODES, player="the same") as player:
                try:
                    self._stream(number, player)
                except grpc.RpcError as error:
                    if error.code() not in SENT_AWAY:
                        raise
                    self._sent_away.set()
            self._over.wait(chance.uniform(0.0, 0.1))

    def _stream(self, number: int, player: Player) -> None:
        while True:
            event = player.next()
            if event.HasField("run_ended"):
                self._over.set()
                return
            if event.HasField("observation") and not event.observation.HasField("taken"):
                self._seen[number].set()
                assert self._seen[1 - number].wait(AT_MOST), "the other one was shown nothing"
                seen, finishes = event.observation, event.observation.step + 1 == len(tiny.ACTIONS)
                answer = partial(player.act, seen.episode_id, seen.step, tiny.ACTIONS[seen.step])
                if finishes and not self._sent_away.is_set():
                    self._pool.submit(self._answer_later, answer)  # and read on: this stream may be the one that ends
                else:
                    answer()

    def _answer_later(self, answer: Callable[[], None]) -> None:
        if self._sent_away.wait(AT_MOST):
            answer()


@pytest.mark.slow
def test_rival_streams_of_one_player_take_every_step_once(servers: list[Server], database_url: str) -> None:
    with ExitStack() as stack:
        pool = stack.enter_context(ThreadPoolExecutor(2 + 2 * EPISODES))
        stubs = [
            EvaluationStub(stack.enter_context(grpc.insecure_channel(server.address)))
            for server in (servers[0], servers[-1])
        ]
        run = create(stubs[0])
        rivals = Rivals(run, pool)
        for playing in [pool.submit(rivals.play, number, stub) for number, stub in enumerate(stubs)]:
            playing.result(timeout=2 * AT_MOST)
        report = stubs[0].GetReport(pb.GetReportRequest(run_id=run.run_id), metadata=METADATA)
    assert report.run.state == pb.RUN_STATE_COMPLETE
    assert {score.mean for row in report.rows for score in row.scores} == {1.0}
    with closing(Database(database_url)) as database:
        journal = Journal(database)
        actions = {each.episode_id: journal.actions(run.run_id, each.episode_id) for each in report.episodes}
    assert actions == {each.episode_id: list(tiny.ACTIONS) for each in report.episodes}


@pytest.mark.slow
def test_two_clients_of_one_run_get_the_undisturbed_result(
    server: Server, tmp_path: Path, undisturbed_run: UndisturbedRun
) -> None:
    """Whose connections break in turn, so that each takes over what the other had."""
    url = journal_url(server.data)
    with Relay(server.address) as first_way, Relay(server.address) as second_way:
        first = client(first_way.address, tmp_path / "first")
        run = run_id(first)
        recorded = played_on(url, run, 0)
        first.send_signal(signal.SIGSTOP)  # or the run might be over before the second one has started
        second = client(second_way.address, tmp_path / "second", "--resume", run)
        assert run_id(second) == run
        first.send_signal(signal.SIGCONT)
        for environment in (first_way, second_way, first_way):
            recorded = played_on(url, run, recorded)
            environment.reset()
        for process in (first, second):
            finish(process)
    for output in ("first", "second"):
        check_same(url, undisturbed_run, results(tmp_path / output))
