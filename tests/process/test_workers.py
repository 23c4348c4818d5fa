"""Several worker processes on one address and one journal."""

import os
import signal
import time
from collections.abc import Collection, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path

import grpc
import pytest

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1.evaluation_pb2_grpc import EvaluationStub
from tests import tiny
from tests.api.player import Player, create
from tests.serving import METADATA, Server

F, L, R, P = 0, 1, 2, 3

needs_proc = pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="finds the workers through Linux's /proc")


@pytest.fixture(scope="module", params=["tcp", "unix", "postgresql"])
def server(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    """Two workers, for several tests: to start them is most of the work. Who ends one waits for the next."""
    folder = tmp_path_factory.mktemp("workers")
    tiny.write(folder / "data", count=8)
    listen = f"unix:{folder}/s" if request.param == "unix" else "127.0.0.1:0"
    cluster = request.getfixturevalue("cluster") if request.param == "postgresql" else None
    journal = ["--journal", cluster.create()] if cluster else []
    server = Server(folder / "data", listen, "--workers", "2", *journal)
    yield server
    assert server.stop() == 0


def information(server: Server) -> pb.ServerInfo:
    with grpc.insecure_channel(server.address) as channel:
        return EvaluationStub(channel).GetServerInfo(pb.GetServerInfoRequest(), metadata=METADATA)


def addresses(server: Server) -> list[str]:
    return list(information(server).addresses)


def children(process_id: int) -> list[int]:
    return [int(child) for child in Path(f"/proc/{process_id}/task/{process_id}/children").read_text().split()]


def test_a_run_is_played_over_both_workers(server: Server) -> None:
    first, second = addresses(server)
    with grpc.insecure_channel(first) as one_channel, grpc.insecure_channel(second) as other_channel:
        one, other = EvaluationStub(one_channel), EvaluationStub(other_channel)
        run = create(one)
        with Player(one, run.run_id, 2, player="a") as a, Player(other, run.run_id, 6, player="b") as b:
            mine = {a.observation().episode_id for _ in range(2)}
            theirs = {b.observation().episode_id for _ in range(6)}
            assert not mine & theirs
            for player, episode_ids in ((a, mine), (b, theirs)):
                for episode_id in episode_ids:
                    player.act(episode_id, 0, tiny.ACTIONS[0])
            with ThreadPoolExecutor() as pool:
                a_events, b_events = pool.map(lambda player: player.play(tiny.ACTIONS), (a, b))
        assert a_events[-1].run_ended.run.episodes_ended == 8
        assert b_events[-1].run_ended.run.state == pb.RUN_STATE_COMPLETE
        report = other.GetReport(pb.GetReportRequest(run_id=run.run_id), metadata=METADATA)
    assert {score.mean for row in report.rows for score in row.scores} == {1.0}


@needs_proc
def test_player_continues_on_another_worker_and_killed_one_restarts(server: Server) -> None:
    first, second = addresses(server)
    with grpc.insecure_channel(first) as channel:
        stub = EvaluationStub(channel)
        run = create(stub, sensors=["pose"])
        with Player(stub, run.run_id, player="p") as player:
            episode_id = player.observation().episode_id
            player.act(episode_id, 0, F)
            assert player.observation().step == 1
            before = children(server.process.pid)
            for worker in before:
                if listens_at(worker, first):
                    os.kill(worker, signal.SIGKILL)
            with pytest.raises(grpc.RpcError):
                player.observation()
    with grpc.insecure_channel(second) as channel, Player(EvaluationStub(channel), run.run_id, player="p") as player:
        seen = player.observation()
        assert (seen.episode_id, seen.step, seen.pose.z) == (episode_id, 1, 1.0)
    while len(children(server.process.pid)) != 2 or children(server.process.pid) == before:
        assert server.process.poll() is None
        time.sleep(0.05)


def kill_again_and_again(process_id: int, spared: Collection[int], times: int) -> None:
    """Kills as many workers as soon as they come, but for those that are spared."""
    deadline = time.monotonic() + 240
    for _ in range(times):
        while not (found := set(children(process_id)) - set(spared)):
            assert time.monotonic() < deadline, "no worker was started again"
            time.sleep(0.02)
        for worker in found:
            os.kill(worker, signal.SIGKILL)
        while found & set(children(process_id)):
            time.sleep(0.02)


@needs_proc
def test_repeatedly_killed_worker_does_not_stop_the_others(tmp_path: Path) -> None:
    tiny.write(tmp_path / "data")
    server = Server(tmp_path / "data", "127.0.0.1:0", "--workers", "2", log=tmp_path / "log")
    other = children(server.process.pid)[1]
    kill_again_and_again(server.process.pid, [other], 7)
    assert server.process.poll() is None
    assert other in children(server.process.pid)
    assert "died with status -9, 6 times in a row; restarting it in 2 s" in (tmp_path / "log").read_text()
    assert information(server).version
    assert server.stop() == 0


@needs_proc
def test_server_exits_if_all_workers_keep_dying(tmp_path: Path) -> None:
    tiny.write(tmp_path / "data")
    server = Server(tmp_path / "data", "127.0.0.1:0", "--workers", "2", log=tmp_path / "log")
    while server.process.poll() is None:
        with suppress(FileNotFoundError, ProcessLookupError):  # the server, or the worker, has ended meanwhile
            for worker in children(server.process.pid):
                os.kill(worker, signal.SIGKILL)
        time.sleep(0.02)
    assert server.wait() == 1
    assert "all workers keep dying soon after their start; see the log above" in (tmp_path / "log").read_text()


def test_server_restarts_with_more_workers_on_a_just_used_port(tmp_path: Path) -> None:
    tiny.write(tmp_path / "data")
    server = Server(tmp_path / "data", "127.0.0.1:0")
    with grpc.insecure_channel(server.address) as channel:
        EvaluationStub(channel).GetServerInfo(pb.GetServerInfoRequest(), metadata=METADATA)
        assert server.stop() == 0
    server.more = ("--workers", "2")
    server.start()
    assert len(addresses(server)) == 2
    assert server.stop() == 0


def test_two_servers_cannot_share_a_port(server: Server, tmp_path: Path) -> None:
    if server.address.startswith("unix:"):
        pytest.skip("a Unix socket is another matter")
    tiny.write(tmp_path / "other")
    with pytest.raises(AssertionError, match=f"cannot listen on '{server.address}': Address already in use"):
        Server(tmp_path / "other", server.address, "--workers", "2")


def listens_at(process_id: int, address: str) -> bool:
    """Whether a process listens at this address: the path of a Unix socket, or a port."""
    sockets = {str(fd.readlink()) for fd in Path(f"/proc/{process_id}/fd").iterdir() if fd.is_symlink()}
    return any(f"socket:[{inode}]" in sockets for inode in _listening(address))


def _listening(address: str) -> Iterator[str]:
    """The inodes of the sockets that listen at an address."""
    if address.startswith("unix:"):
        for line in Path("/proc/net/unix").read_text().splitlines()[1:]:
            fields = line.split()
            if fields[7:] == [address.removeprefix("unix:")] and fields[3] == "00010000":
                yield fields[6]
        return
    port = f"{int(address.rpartition(':')[2]):04X}"
    for table in ("tcp", "tcp6"):
        for line in Path(f"/proc/net/{table}").read_text().splitlines()[1:]:
            fields = line.split()
            if fields[1].endswith(f":{port}") and fields[3] == "0A":
                yield fields[9]
