"""A server under attack, and a well-behaved client that plays beside it."""

import threading
from collections.abc import Iterator
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


class Neighbour:
    """Plays run after run in the background, and keeps their scores."""

    def __init__(self, address: str) -> None:
        self._address = address
        self._leave = threading.Event()
        self.scores: list[pb.Report] = []
        self.failures: list[BaseException] = []
        self._thread = threading.Thread(target=self._live)
        self._thread.start()

    def leave(self) -> None:
        self._leave.set()
        self._thread.join(60)
        assert not self._thread.is_alive()

    def _live(self) -> None:
        try:
            with grpc.insecure_channel(self._address, options=[("grpc.use_local_subchannel_pool", 1)]) as channel:
                stub = EvaluationStub(channel)
                while not self._leave.is_set():
                    self.scores.append(played(stub))
        except BaseException as error:  # noqa: BLE001 - told by the test's own thread
            self.failures.append(error)


def played(stub: EvaluationStub) -> pb.Report:
    """The report of one run along the ground truth, its own name and times left out."""
    run = create(stub, sensors=["rgb"])
    with Player(stub, run.run_id, 4) as player:
        player.play(tiny.ACTIONS)
    report = stub.GetReport(pb.GetReportRequest(run_id=run.run_id), metadata=METADATA)
    report.run.ClearField("run_id")
    report.run.ClearField("created_at")
    report.run.ClearField("ended_at")
    return report


@pytest.fixture
def neighbour(server: Server) -> Iterator[Neighbour]:
    """Beside each attack; afterwards every run of it is as it would have been without."""
    with grpc.insecure_channel(server.address) as channel:
        undisturbed = played(EvaluationStub(channel))
    neighbour = Neighbour(server.address)
    yield neighbour
    neighbour.leave()
    assert not neighbour.failures
    assert neighbour.scores
    assert all(report == undisturbed for report in neighbour.scores)
    with grpc.insecure_channel(server.address) as channel:
        assert played(EvaluationStub(channel)) == undisturbed
