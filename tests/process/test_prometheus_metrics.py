"""Prometheus metrics of a known run, in one process and summed over two."""

import os
import signal
import time
import urllib.request
from collections.abc import Callable, Iterator
from pathlib import Path

import grpc
import pytest
from prometheus_client.parser import text_string_to_metric_families

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1.evaluation_pb2_grpc import EvaluationStub
from tests import tiny
from tests.api.player import Player, create
from tests.physics import ANY_CAMERA
from tests.process.test_workers import addresses, children
from tests.serving import METADATA, Server

EPISODES = 3
STEPS = EPISODES * len(tiny.ACTIONS)

Samples = dict[tuple[str, frozenset[tuple[str, str]]], float]


@pytest.fixture(params=[1, 2], ids=["1 worker", "2 workers"])
def server(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Server]:
    tiny.write(tmp_path / "data", count=EPISODES)
    options = ("--workers", str(request.param), "--web", "127.0.0.1:0", "--camera", ANY_CAMERA)
    server = Server(tmp_path / "data", "127.0.0.1:0", *options)
    yield server
    assert server.stop() == 0


def wait_until(condition: Callable[[], bool]) -> None:
    end = time.monotonic() + 240
    while not condition():
        assert time.monotonic() < end, "nothing changed in four minutes"
        time.sleep(0.2)


def text(server: Server) -> str:
    (address,) = (line.split()[-1] for line in server.said if line.startswith("metrics at "))
    with urllib.request.urlopen(address + "/metrics", timeout=120) as response:
        said: str = response.read().decode()
    return said


def samples(server: Server) -> Samples:
    families = text_string_to_metric_families(text(server))
    return {(each.name, frozenset(each.labels.items())): each.value for family in families for each in family.samples}


def value(found: Samples, name: str, **labels: str) -> float:
    return found.get((f"arramon_{name}", frozenset(labels.items())), 0.0)


def test_metrics_count_a_known_run(server: Server) -> None:
    before = samples(server)
    assert value(before, "steps_total") == 0
    with grpc.insecure_channel(addresses(server)[-1] if addresses(server) else server.address) as channel:
        stub = EvaluationStub(channel)
        run = create(stub, sensors=["rgb"])
        with Player(stub, run.run_id, EPISODES) as player:
            player.play(tiny.ACTIONS)
        with pytest.raises(grpc.RpcError):
            stub.GetRun(pb.GetRunRequest(run_id="nonsense"), metadata=METADATA)
    # A call is counted after its answer has left, so the caller can be here first.
    wait_until(lambda: value(samples(server), "rpcs_total", method="GetRun", status="NOT_FOUND") == 1)
    # Any process shows the sum of all: the port is shared, so that several looks see several of them.
    for _ in range(6):
        found = samples(server)
        assert value(found, "runs_created_total") == 1
        assert value(found, "runs_ended_total", state="COMPLETE") == 1
        assert value(found, "runs", state="COMPLETE") == 1
        assert value(found, "episodes_ended_total", cause="AGENT_FINISHED") == EPISODES
        assert value(found, "episodes_reoffered_total") == 0
        assert value(found, "steps_total") == STEPS
        assert value(found, "frames_total", camera=ANY_CAMERA) == STEPS  # one for each step, none after the last
        assert value(found, "rpcs_total", method="CreateRun", status="OK") == 1
        assert value(found, "rpcs_total", method="GetRun", status="NOT_FOUND") == 1
        assert value(found, "stage_seconds_count", stage="draw") == STEPS
        for stage in ("queue", "rules", "commit", "encode", "total"):
            assert 0 < value(found, "stage_seconds_count", stage=stage) <= STEPS + 10, stage
        assert value(found, "stage_seconds_sum", stage="draw") > 0
    # These two gauges are written once a second.
    wait_until(lambda: not value(samples(server), "streams_open") and not value(samples(server), "episodes_open"))
    assert value(found, "processes_ready") == len(addresses(server) or [1])


def test_metrics_contain_no_ids_or_names(server: Server) -> None:
    with grpc.insecure_channel(server.address) as channel:
        stub = EvaluationStub(channel)
        run = create(stub, participant="Somebody", agent="something")
        with Player(stub, run.run_id, EPISODES, player="me") as player:
            player.play(tiny.ACTIONS)
        for method in ("/arramon.v1.Evaluation/Invented", "/invented.Service/Invented"):
            with pytest.raises(grpc.RpcError):
                channel.unary_unary(method)(b"")  # type: ignore[arg-type]
    said = text(server)
    for secret in (run.run_id, "Somebody", "something", 'me"', "Invented", "invented"):
        assert secret not in said, secret
    labels = {name for _, found in samples(server) for name, _ in found}
    assert labels == {"state", "cause", "camera", "method", "status", "stage", "le", "version"} | labels & {"kind"}


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="finds the workers through Linux's /proc")
def test_counts_of_dead_workers_are_kept(tmp_path: Path) -> None:
    tiny.write(tmp_path / "data", count=EPISODES)
    server = Server(tmp_path / "data", "127.0.0.1:0", "--workers", "2", "--web", "127.0.0.1:0")
    try:
        with grpc.insecure_channel(server.address) as channel:
            stub = EvaluationStub(channel)
            with Player(stub, create(stub).run_id, EPISODES) as player:
                player.play(tiny.ACTIONS)
        before = children(server.process.pid)
        for worker in before:
            os.kill(worker, signal.SIGKILL)
        wait_until(lambda: not set(children(server.process.pid)) & set(before) and ready(server) == 2)
        found = samples(server)
        assert value(found, "steps_total") == STEPS
        assert value(found, "episodes_ended_total", cause="AGENT_FINISHED") == EPISODES
    finally:
        assert server.stop() == 0


def ready(server: Server) -> float:
    try:
        return value(samples(server), "processes_ready")
    except OSError:  # while no process listens
        return 0.0
