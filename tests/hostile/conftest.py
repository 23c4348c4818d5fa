"""A server under attack, and a well-behaved client that plays beside it."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import grpc
import pytest

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1.evaluation_pb2_grpc import EvaluationStub
from tests import tiny
from tests.api.player import Player, create
from tests.serving import METADATA, Server


@pytest.fixture(scope="package")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    data = tmp_path_factory.mktemp("data")
    tiny.write(data)
    tiny.write(data, "secret", 3, hidden=True)
    log = data / "server.log"
    server = Server(data, "127.0.0.1:0", "--steps", "8", log=log)
    yield server
    assert server.stop() == 0, log.read_text()


def memory(server: Server) -> int:
    """What a server holds, in MiB."""
    lines = Path(f"/proc/{server.process.pid}/status").read_text().splitlines()
    return next(int(line.split()[1]) // 1024 for line in lines if line.startswith("VmRSS"))


REST = 0.2
"""Seconds between two runs of the neighbour: without, it would keep the machine busier than the attack does."""


class Neighbour:
    """Plays run after run in the background, and keeps their scores."""

    def __init__(self, address: str) -> None:
        self._address = address
        self._leave = threading.Event()
        self.scores: list[pb.Report] = []
        self.failures: list[BaseException] = []
        self._thread = threading.Thread(target=self._live)
        self._thread.start()

    def play_on(self, runs: int) -> None:
        """Wait until so many more runs of it have ended."""
        until = len(self.scores) + runs
        while len(self.scores) < until:
            assert self._thread.is_alive(), self.failures
            self._thread.join(0.05)

    def leave(self) -> None:
        self._leave.set()
        self._thread.join(240)
        assert not self._thread.is_alive()

    def _live(self) -> None:
        try:
            with grpc.insecure_channel(self._address, options=[("grpc.use_local_subchannel_pool", 1)]) as channel:
                stub = EvaluationStub(channel)
                while not (self.scores and self._leave.is_set()):
                    self.scores.append(played(stub))
                    self._leave.wait(REST)
        except BaseException as error:  # noqa: BLE001 - told by the test's own thread
            self.failures.append(error)


def played(stub: EvaluationStub) -> pb.Report:
    """The report of one run along the ground truth, its own name and times left out."""
    run = create(stub, sensors=["rgb"])
    with Player(stub, run.run_id, 4) as player:
        player.play(tiny.ACTIONS)
    report = stub.GetReport(pb.GetReportRequest(run_id=run.run_id), metadata=METADATA)
    for name in ("run_id", "created_at", "ended_at", "thinking_seconds", "timed_steps"):
        report.run.ClearField(name)
    return report


@pytest.fixture(scope="package")
def undisturbed(server: Server) -> pb.Report:
    """What a run along the ground truth is worth where nobody attacks."""
    with grpc.insecure_channel(server.address) as channel:
        return played(EvaluationStub(channel))


@contextmanager
def beside(server: Server, undisturbed: pb.Report) -> Iterator[Neighbour]:
    """A neighbour plays while the block attacks; every run of it, and one after the attack, is as without."""
    neighbour = Neighbour(server.address)
    try:
        yield neighbour
    finally:
        neighbour.leave()
    assert not neighbour.failures
    assert neighbour.scores
    assert all(report == undisturbed for report in neighbour.scores)
    with grpc.insecure_channel(server.address) as channel:
        assert played(EvaluationStub(channel)) == undisturbed
