"""Servers that a program starts end with it: the client's own, and a host's workers."""

import os
import signal
from pathlib import Path

import pytest

from arramon_client.local import lifeline
from tests import tiny
from tests.client.environments.test_killed import ends, program

EMBEDDED = """
import os, sys, time
from pathlib import Path
from arramon_client.local.embedded import embedded_server

with embedded_server(Path(sys.argv[1])) as server:
    if os.fork() == 0:  # It holds the end of the server's standard input.
        time.sleep(1000)
    print(os.getpid(), server._process.pid, flush=True)
    time.sleep(1000)
"""

SLEEPER = """
import os, subprocess, sys, time

child = subprocess.Popen([sys.executable, "-m", "arramon_client.local.lifeline", "sleeper"], stdin=subprocess.PIPE,
                         stdout=subprocess.PIPE, cwd=os.path.dirname(__file__), text=True)
child.stdout.readline()
if os.fork() == 0:
    time.sleep(1000)
print(os.getpid(), child.pid, flush=True)
time.sleep(1000)
"""


def test_an_embedded_server_ends_with_its_client(tmp_path: Path) -> None:
    tiny.write(tmp_path / "data")
    with program(EMBEDDED, tmp_path, str(tmp_path / "data")) as process:
        assert process.stdout is not None
        owner, server = map(int, process.stdout.readline().split())
        has_ended = ends(server)
        os.kill(owner, signal.SIGKILL)
        assert has_ended()


def test_the_launcher_ends_with_its_parent_though_its_input_is_held_open(tmp_path: Path) -> None:
    """As for the workers of a host (`server/process/workers.py`), which are started by it."""
    (tmp_path / "sleeper.py").write_text("import time\nprint('ready', flush=True)\ntime.sleep(1000)\n")
    with program(SLEEPER, tmp_path) as process:
        assert process.stdout is not None
        owner, child = map(int, process.stdout.readline().split())
        has_ended = ends(child)
        os.kill(owner, signal.SIGKILL)
        assert has_ended()


def test_without_handles_of_processes_the_parent_is_looked_at(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As on macOS, which has no `os.pidfd_open`."""
    monkeypatch.delattr(os, "pidfd_open")
    ended = []
    silent, _other = os.pipe()
    child = os.fork()
    if child == 0:
        os._exit(0)
    os.waitpid(child, 0)
    thread = lifeline._watch([silent], child, lambda: ended.append(True))
    assert thread is not None
    thread.join(60.0)
    assert ended == [True]
