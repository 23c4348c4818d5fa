"""Clocks over gRPC: the time left in observations, and ends of episodes that run out of time."""

import time
from collections.abc import Iterator, Sequence
from pathlib import Path

import grpc
import pytest

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1 import types_pb2
from arramon.v1.evaluation_pb2_grpc import EvaluationStub
from arramon_client import Episode, Observation, Settings, connect, play, receipts
from arramon_client.observations import observation_of
from arramon_client.transport.images import ImageDecoder
from tests import tiny
from tests.api.player import Player, create
from tests.serving import METADATA, Server


@pytest.fixture(scope="module")
def hasty(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    """A server that grants next to nothing."""
    data = tmp_path_factory.mktemp("data")
    tiny.write(data)
    seconds = {"step": "0.3", "bank": "0.2"}
    server = Server(data, "127.0.0.1:0", *(word for name, n in seconds.items() for word in (f"--{name}-seconds", n)))
    yield server
    assert server.stop() == 0


@pytest.fixture
def hurry(hasty: Server) -> Iterator[EvaluationStub]:
    with grpc.insecure_channel(hasty.address) as channel:
        yield EvaluationStub(channel)


def get(stub: EvaluationStub, run_id: str) -> pb.Run:
    return stub.GetRun(pb.GetRunRequest(run_id=run_id), metadata=METADATA)


def test_runs_have_the_hosts_clocks_and_observations_the_time_left(stub: EvaluationStub) -> None:
    limits = stub.GetServerInfo(pb.GetServerInfoRequest(), metadata=METADATA).limits
    assert (limits.step_seconds, limits.bank_seconds) == (60.0, 86_400.0)
    run = create(stub, episodes=1)
    assert run.limits == limits
    assert run.bank_seconds_left == 86_400.0
    with Player(stub, run.run_id, player="one") as player:
        first = player.observation()
        player.act(first.episode_id, 0, tiny.F)
        second = player.observation()
    assert [(seen.step_seconds_left, seen.bank_seconds_left) for seen in (first, second)] == [(60, 86_400)] * 2
    observed = observation_of(second, ImageDecoder())
    assert (observed.step_seconds_left, observed.bank_seconds_left) == (60.0, 86_400.0)
    with Player(stub, run.run_id, player="one", history=True) as player:
        past, now = player.observation(), player.observation()
    assert [seen.HasField("step_seconds_left") for seen in (past, now)] == [False, True]


def test_silent_client_runs_out_of_time_and_its_run_completes(hurry: EvaluationStub) -> None:
    run = create(hurry, episodes=3)
    with Player(hurry, run.run_id, 2) as player:
        events = list(player._events)
    ended = [event.episode_ended.cause for event in events if event.HasField("episode_ended")]
    assert ended == [types_pb2.CAUSE_TIME_LIMIT] * 3
    phases = [event.phase_ended for event in events if event.HasField("phase_ended")]
    assert len(phases) == 12
    assert all(phase.forced for phase in phases)
    assert events[-1].run_ended.run.state == pb.RUN_STATE_COMPLETE
    over = get(hurry, run.run_id)
    assert (dict(over.causes), over.steps, over.bank_seconds_left) == ({"TIME_LIMIT": 3}, 0, 0.0)
    report = hurry.GetReport(pb.GetReportRequest(run_id=run.run_id), metadata=METADATA)
    assert "|clock:0.3/0.2|" in report.signature
    assert [episode.cause for episode in report.episodes] == [types_pb2.CAUSE_TIME_LIMIT] * 3


def test_late_answer_causes_no_second_episode_end(hurry: EvaluationStub) -> None:
    run = create(hurry, episodes=1)
    with Player(hurry, run.run_id) as player:
        seen = player.observation()
        while not (event := player.next()).HasField("episode_ended"):
            pass
        assert event.episode_ended.cause == types_pb2.CAUSE_TIME_LIMIT
        player.act(seen.episode_id, 0, tiny.F)
        assert [event.WhichOneof("event") for event in player._events] == ["run_ended"]


class Late:
    """Answers one step only when the server has ended its episode; plays the ground truth otherwise."""

    def __init__(self, stub: EvaluationStub, run_id: str, step: int) -> None:
        self._stub, self._run_id, self._step = stub, run_id, step
        self.late: list[str] = []

    def begin(self, episode: Episode) -> None:
        pass

    def act(self, observations: Sequence[Observation]) -> list[int]:
        (seen,) = observations
        if seen.step == self._step:
            self.late.append(seen.episode_id)
            while get(self._stub, self._run_id).causes.get("TIME_LIMIT", 0) < len(self.late):
                time.sleep(0.05)
        return [tiny.ACTIONS[seen.step]]


def test_recorded_actions_of_a_late_client_match_the_receipt(tmp_path: Path) -> None:
    tiny.write(tmp_path / "data", count=2)
    clocks = ("--step-seconds", "2", "--bank-seconds", "0")
    server = Server(tmp_path / "data", "127.0.0.1:0", *clocks)
    with connect(server.address) as connected:
        run = create(connected.stub)
        agent = Late(connected.stub, run.run_id, 3)
        outcome = play(connected.stub, run, agent, Settings(parallel=1))
        receipt = connected.stub.GetReceipt(pb.GetReceiptRequest(run_id=run.run_id), metadata=METADATA)
    assert server.stop() == 0
    assert outcome.run.causes["TIME_LIMIT"] >= 1
    kept = receipts.read_receipt(receipts.write_receipt(receipt, run.run_id, tmp_path))
    assert receipts.compare_actions(kept, outcome.actions) == receipts.Comparison(2, ())
