"""Streams ended in every way, at every log level: the server survives and reports no defect."""

import asyncio
import subprocess
import sys
from pathlib import Path

import grpc
import pytest

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1.evaluation_pb2_grpc import EvaluationStub
from tests import tiny
from tests.api.player import create
from tests.hostile.endings import ENDINGS, end
from tests.serving import METADATA, Server

STREAMS = 20
"""That are ended in each way: a hundred at each level."""


@pytest.mark.parametrize("level", ["debug", "info", "warning", "error"])
def test_server_survives_every_way_of_ending_streams(tmp_path: Path, level: str) -> None:
    tiny.write(tmp_path / "data", count=STREAMS)
    log = tmp_path / "log"
    server = Server(tmp_path / "data", "127.0.0.1:0", "--log", level, log=log)
    with grpc.insecure_channel(server.address) as channel:
        stub = EvaluationStub(channel)
        for ending in ENDINGS:
            run = create(stub, sensors=["rgb"])
            _end(server, run.run_id, ending, [str(number) for number in range(STREAMS)])
            assert stub.GetRun(pb.GetRunRequest(run_id=run.run_id), metadata=METADATA).run_id == run.run_id
            assert server.process.poll() is None, log.read_text()[-2000:]
        assert stub.GetServerInfo(pb.GetServerInfoRequest(), metadata=METADATA).version
    assert server.stop() == 0
    said = log.read_text()
    assert " ERROR " not in said
    assert "Traceback" not in said
    if level in ("debug", "info"):
        ended = [line for line in said.splitlines() if "call ended method=/arramon.v1.Evaluation/Play" in line]
        # Who has a deadline may not even have begun, and of who is killed only the end of what they say may be seen.
        assert sum(" status=CANCELLED " in line for line in ended) > STREAMS
        assert sum(" status=OK " in line for line in ended) >= STREAMS
        assert {line.partition(" peer=")[2] for line in ended} <= {"127.0.0.0/24", "unknown"}


def _end(server: Server, run_id: str, ending: str, players: list[str]) -> None:
    if ending != "kill":
        asyncio.run(end(server.address, run_id, ending, players))
        return
    command = [sys.executable, "-m", "tests.hostile.endings", server.address, run_id, ending, *players]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as client:
        assert client.stdout is not None
        assert client.stdout.readline() == "open\n"
        client.kill()
