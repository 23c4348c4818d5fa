"""Signals that stop the client: in order, with the way to resume, and without a server that is left behind."""

import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest

from arramon.v1 import evaluation_pb2 as pb
from arramon_client.cli import main
from tests import ROOT, tiny
from tests.client.fake import RUN, Servicer, World, serving

SLOW = """
import os, sys, time
print("loading", flush=True)
{load}
class Agent:
    sensors = ()
    def begin(self, episode): print("begun", flush=True)
    def act(self, observations):
        print("acting", flush=True)
        {act}
"""

WAITING = """
import asyncio, time
class Agent:
    sensors = ()
    def begin(self, episode): pass
    async def act(self, observation):
        print("acting", flush=True)
        {act}
    async def close(self): print("closed", flush=True)
"""

ENDED = 1200
"""Looks for the end of a process, a tenth of a second apart."""


class Client:
    """A client in a process of its own, in the folder of an agent `slow`."""

    def __init__(
        self, folder: Path, *arguments: str, load: str = "", act: str = "time.sleep(600)", agent: str = SLOW
    ) -> None:
        (folder / "slow.py").write_text(agent.format(load=load, act=act))
        command = [sys.executable, "-m", "arramon_client", "--agent", "slow", "--lang", "en", *arguments]
        environment = {**os.environ, "ARRAMON_CAMERA": "tiny", "ARRAMON_STEPS": "20"}
        self.process = subprocess.Popen(
            command, cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )

    def wait_for(self, word: str) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            if line.strip() == word:
                return
        assert self.process.stderr is not None
        raise AssertionError(self.process.stderr.read())

    def stop(self, *signals: int) -> tuple[int, str]:
        for number in signals:
            self.process.send_signal(number)
        self.rest, errors = self.process.communicate(timeout=120)
        assert "Traceback" not in errors, errors
        return self.process.returncode, errors


@pytest.fixture
def address(world: World) -> Iterator[str]:
    with serving(Servicer(world)) as served:
        yield served


@pytest.mark.parametrize(("sent", "status", "said"), [
    ((signal.SIGTERM,), 143, "stopped by SIGTERM"), ((signal.SIGHUP,), 129, "stopped by SIGHUP"),
    ((signal.SIGTERM, signal.SIGTERM), 143, "stopped by SIGTERM"),
])  # fmt: skip
@pytest.mark.parametrize("parallel", ["1", "8"])
def test_a_signal_stops_a_slow_agent_and_the_resume_command_is_printed(
    world: World, address: str, tmp_path: Path, sent: Sequence[int], status: int, said: str, parallel: str
) -> None:
    """`timeout` sends SIGTERM twice: to its child, and to the group of both."""
    client = Client(tmp_path, "--server", address, "--parallel", parallel)
    client.wait_for("acting")
    found, errors = client.stop(*sent)
    assert (found, f"{said}\nthe run is saved; resume it with\n" in errors, f"--resume {RUN}" in errors) == (
        status, True, True,
    )  # fmt: skip
    assert world.causes == {}


@pytest.mark.parametrize(("sent", "status", "said"), [
    (signal.SIGTERM, 143, "stopped by SIGTERM"), (signal.SIGINT, 130, "interrupted"),
])  # fmt: skip
@pytest.mark.parametrize("act", ["await asyncio.sleep(600)", "time.sleep(600)"])
def test_a_signal_stops_an_agent_that_waits(
    world: World, address: str, tmp_path: Path, sent: signal.Signals, status: int, said: str, act: str
) -> None:
    client = Client(tmp_path, "--server", address, "--parallel", "2", act=act, agent=WAITING)
    client.wait_for("acting")
    found, errors = client.stop(sent)
    assert (found, f"{said}\nthe run is saved; resume it with\n" in errors) == (status, True)
    assert ("closed" in client.rest.splitlines()) == ("await" in act)  # A call that blocks is not waited for.
    assert world.causes == {}


def test_a_signal_while_the_agent_loads_its_weights(world: World, address: str, tmp_path: Path) -> None:
    client = Client(tmp_path, "--server", address, load="time.sleep(600)")
    client.wait_for("loading")
    assert client.stop(signal.SIGTERM) == (143, "stopped by SIGTERM\n")
    assert world.requests == []


def test_a_signal_while_connecting(tmp_path: Path) -> None:
    """To a server that accepts connections and says nothing; a resumed run waits for it for minutes."""
    with socket.create_server(("127.0.0.1", 0)) as silent:
        client = Client(tmp_path, "--server", f"127.0.0.1:{silent.getsockname()[1]}", "--resume", RUN)
        client.wait_for("loading")
        connection, _ = silent.accept()
        with connection:
            found, errors = client.stop(signal.SIGTERM)
    assert (found, f"--resume {RUN}" in errors) == (143, True)


def test_a_signal_stops_several_streams_while_one_waits_for_the_agent(tmp_path: Path, world: World) -> None:
    """The agent is called in a thread, which nobody waits for."""
    with serving(Servicer(world)) as first, serving(Servicer(world)) as second:
        world.info.addresses.extend([first, second])
        client = Client(tmp_path, "--server", first)
        client.wait_for("acting")
        found, errors = client.stop(signal.SIGTERM)
    assert (found, f"--resume {RUN}" in errors) == (143, True)


def test_a_stopped_dry_run_is_cancelled(world: World, address: str, tmp_path: Path) -> None:
    client = Client(tmp_path, "--server", address, "--dry-run")
    client.wait_for("acting")
    found, errors = client.stop(signal.SIGTERM)
    assert (found, "--resume" in errors, world.cancelled) == (143, False, [RUN])


@pytest.mark.parametrize("when", ["begun", "acting"])
def test_the_embedded_server_is_stopped_with_the_client(tmp_path: Path, when: str) -> None:
    tiny.write(tmp_path / "arramon-data")
    client = Client(tmp_path, "--parallel", "2")
    client.wait_for(when)
    children = subprocess.run(
        ["ps", "-o", "pid=", "--ppid", str(client.process.pid)], capture_output=True, text=True, check=True
    ).stdout.split()
    servers = [int(pid) for pid in children if b"serve" in Path(f"/proc/{pid}/cmdline").read_bytes().split(b"\0")]
    assert servers
    found, errors = client.stop(signal.SIGTERM)
    assert (found, "resume it with\n" in errors) == (143, True)
    assert not any(map(is_alive, servers))


def test_a_client_that_is_killed_leaves_no_server_behind(tmp_path: Path) -> None:
    tiny.write(tmp_path / "arramon-data")
    client = Client(tmp_path)
    client.wait_for("acting")
    children = subprocess.run(
        ["ps", "-o", "pid=", "--ppid", str(client.process.pid)], capture_output=True, text=True, check=True
    ).stdout.split()
    client.process.kill()
    client.process.communicate()
    for _ in range(ENDED):
        if not any(is_alive(int(pid)) for pid in children):
            break
        time.sleep(0.1)
    assert not any(is_alive(int(pid)) for pid in children)


def is_alive(pid: int) -> bool:
    """Whether a process runs; one that has ended and was not waited for does not."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


def test_processes_that_the_agent_forks_die_of_the_signal_as_usual(address: str, tmp_path: Path) -> None:
    """As `multiprocessing` ends its own: without a traceback."""
    load = (
        "reading, writing = os.pipe()\n"
        "child = os.fork()\n"
        "if not child:\n"
        "    os.write(writing, b'x')\n"
        "    time.sleep(600)\n"
        "os.read(reading, 1)\n"
        "os.kill(child, 15)\n"
        "print('child', os.WTERMSIG(os.waitpid(child, 0)[1]), flush=True)"
    )
    client = Client(tmp_path, "--server", address, load=load)
    client.wait_for("child 15")
    assert client.stop(signal.SIGTERM)[0] == 143


def test_a_signal_that_is_ignored_stays_ignored(world: World, address: str, tmp_path: Path) -> None:
    """`nohup` ignores SIGHUP."""
    (tmp_path / "quick.py").write_text(
        "import os, signal\nclass Agent:\n    sensors = ()\n"
        "    def begin(self, e): os.kill(os.getpid(), signal.SIGHUP)\n"
        "    def act(self, o): return [0 for _ in o]\n"
    )
    command = f"exec nohup {sys.executable} -m arramon_client --agent quick --lang en --server {address}"
    done = subprocess.run(["sh", "-c", command], cwd=tmp_path, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr


def test_handlers_of_the_calling_program_are_restored(address: str, tmp_path: Path) -> None:
    before = signal.getsignal(signal.SIGTERM), signal.getsignal(signal.SIGHUP)
    assert main(["account", "--server", address]) == 0
    assert (signal.getsignal(signal.SIGTERM), signal.getsignal(signal.SIGHUP)) == before


def test_a_subcommand_is_stopped_with_the_same_status(tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as silent:
        address = f"127.0.0.1:{silent.getsockname()[1]}"
        command = [sys.executable, "-m", "arramon_client", "runs", "--server", address]
        with subprocess.Popen(command, cwd=ROOT, stderr=subprocess.PIPE, text=True) as client:
            connection, _ = silent.accept()
            with connection:
                client.send_signal(signal.SIGTERM)
                _, errors = client.communicate(timeout=120)
    assert (client.returncode, errors) == (143, "stopped by SIGTERM\n")


def test_a_run_that_was_stopped_is_resumed(
    world: World, address: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    client = Client(tmp_path, "--server", address, "--parallel", "2")
    client.wait_for("acting")
    assert client.stop(signal.SIGTERM)[0] == 143
    (tmp_path / "slow.py").write_text(SLOW.format(load="", act="return [0 for _ in observations]"))
    command = [sys.executable, "-m", "arramon_client", "--agent", "slow", "--server", address, "--resume", RUN]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert world.current_run().state == pb.RUN_STATE_COMPLETE
