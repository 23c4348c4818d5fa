"""The embedded server: start, restart and stop, also when the client is killed."""

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from arramon_client import EmbeddedServerError, connect, embedded_server
from arramon_client.local.embedded import NOTICE_TIMEOUT, START_TIMEOUT, default_data
from tests import ROOT

SERVER = """
import queue, signal, sys, time
from tests.client.fake import Servicer, World, serving
stopped = queue.SimpleQueue()  # An event's lock may be held by the thread that the signal interrupts.
signal.signal(signal.SIGTERM, lambda *_: stopped.put("now"))
assert sys.argv[1:3] == ["serve", "--listen"] and sys.argv[4] == "--data", sys.argv
with serving(Servicer(World()), sys.argv[3]):
    print("a word before", flush=True)
    print("compiling something; this is done once", flush=True)
    print("listening on", sys.argv[3], flush=True)
    while True:  # A signal that the system delivers to another thread does not end a wait.
        try:
            stopped.get(timeout=0.2)
            break
        except queue.Empty:
            pass
open(sys.argv[5] + "/stopped", "a").write("in good order\\n")
"""


@pytest.fixture
def module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """Name of a module that serves like the real server; its source is SERVER unless the test overwrites it."""
    monkeypatch.setenv("PYTHONPATH", f"{tmp_path}{os.pathsep}{ROOT}")
    monkeypatch.syspath_prepend(str(tmp_path))
    (tmp_path / "scripted_server.py").write_text(SERVER)
    return "scripted_server"


def test_embedded_server_serves_and_stops_cleanly(module: str, tmp_path: Path) -> None:
    notices: list[str] = []
    with embedded_server(tmp_path, module=module, notify=notices.append) as embedded:
        assert notices == ["compiling something; this is done once"]
        assert embedded.address.startswith("unix:/")
        with connect(embedded.address) as server:
            assert server.info.version == "9.9.9"
    assert (tmp_path / "stopped").read_text() == "in good order\n"
    assert not Path(embedded.address.removeprefix("unix:")).parent.exists()


@pytest.mark.parametrize("name", ["queue", "secrets"])
def test_modules_of_the_working_directory_are_not_the_servers(
    name: str, module: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A participant's `queue.py` does not replace the library's in the server's process."""
    own = tmp_path / "own"
    own.mkdir()
    (own / f"{name}.py").write_text("raise RuntimeError('a module of the working directory was imported')\n")
    monkeypatch.chdir(own)
    (tmp_path / "scripted_server.py").write_text(f"import secrets\n{SERVER}")
    with embedded_server(tmp_path, module=module) as embedded, connect(embedded.address) as server:
        assert server.info.protocol == 1


def test_a_killed_server_is_restarted_at_the_same_address(module: str, tmp_path: Path) -> None:
    with embedded_server(tmp_path, module=module) as embedded:
        process = embedded._process
        assert process is not None
        embedded.revive()
        assert embedded._process is process, "one that lives is left alone"
        os.kill(process.pid, signal.SIGKILL)
        process.wait(120)
        embedded.revive()
        with connect(embedded.address) as server:
            assert server.info.protocol == 1


def test_the_output_of_a_server_that_fails_to_start_is_shown(module: str, tmp_path: Path) -> None:
    (tmp_path / "scripted_server.py").write_text("raise SystemExit('no such data folder: /nowhere')")
    with (
        pytest.raises(EmbeddedServerError, match="did not start\nno such data folder: /nowhere"),
        embedded_server(tmp_path, module=module),
    ):
        pass


def test_an_announced_compilation_may_take_longer(module: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The first limit is over when the notice has arrived; only then does the server go on."""
    go, noticed = tmp_path / "go", threading.Event()
    waits = f"while not Path({str(go)!r}).exists() and stopped.empty(): time.sleep(0.01)"
    source = SERVER.replace('    print("listening', f'    {waits}\n    print("listening')
    (tmp_path / "scripted_server.py").write_text(f"from pathlib import Path\n{source}")

    class Hurried(threading.Event):
        def wait(self, timeout: float | None = None) -> bool:
            if timeout == START_TIMEOUT:
                noticed.wait()
                return False
            if timeout == NOTICE_TIMEOUT:
                go.touch()
            return super().wait(timeout)

    monkeypatch.setattr(threading, "Event", Hurried)
    with embedded_server(tmp_path, module=module, notify=lambda _: noticed.set()) as embedded:
        assert go.exists()
        with connect(embedded.address) as server:
            assert server.info.protocol == 1


def test_missing_server_package_is_reported(tmp_path: Path) -> None:
    with (
        pytest.raises(EmbeddedServerError, match="install it, or name a server with --server"),
        embedded_server(tmp_path, module="no_such_server"),
    ):
        pass


def test_the_server_does_not_outlive_a_killed_client(module: str, tmp_path: Path) -> None:
    client = subprocess.Popen(
        [sys.executable, "-c", "import sys, time, pathlib; from arramon_client import embedded_server\n"
         f"with embedded_server(pathlib.Path({str(tmp_path)!r}), module={module!r}):\n"
         "    print('up', flush=True); time.sleep(600)"],
        stdout=subprocess.PIPE, text=True, cwd=tmp_path,
    )  # fmt: skip
    with client:
        assert client.stdout is not None
        assert client.stdout.readline() == "up\n"
        client.kill()
    for _ in range(1200):  # as it is no child of this process, there is nothing else to wait for
        if (tmp_path / "stopped").exists() and (tmp_path / "stopped").read_text().endswith("\n"):
            break
        time.sleep(0.1)
    assert (tmp_path / "stopped").read_text() == "in good order\n"


@pytest.mark.parametrize(("value", "path"), [(None, "arramon-data"), ("", "arramon-data"), ("/srv/data", "/srv/data")])
def test_data_folder_comes_from_the_environment_or_default(
    monkeypatch: pytest.MonkeyPatch, value: str | None, path: str
) -> None:
    if value is None:
        monkeypatch.delenv("ARRAMON_DATA", raising=False)
    else:
        monkeypatch.setenv("ARRAMON_DATA", value)
    assert default_data() == Path(path)
