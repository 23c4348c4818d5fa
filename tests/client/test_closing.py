"""What a program forgets to close is closed at its end, while its threads still run, and by no forked process."""

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from arramon_client.closing import close_once
from tests import tiny
from tests.serving import Server

FORGETFUL = """
import os, sys
from arramon_client.closing import close_once

class Thing:
    def __init__(self, name):
        self.close = close_once(self, lambda: print(name, "closed", flush=True))

first, second, third = Thing("first"), Thing("second"), Thing("third")
if os.fork() == 0:
    third.close()
    sys.exit()
os.wait()
second.close()
print("the end", flush=True)
"""

DOORS = """
import os, sys
import grpc._channel
import gymnasium
import arramon_client
from arramon_client.environments import two_agents

def watched(channel, close=grpc._channel.Channel.close, is_finalizing=sys.is_finalizing, write=os.write):
    write(1, b"closed late " if is_finalizing() else b"closed ")  # Late, `close` may wait for ever.
    close(channel)

grpc._channel.Channel.close = watched
host = {"server": sys.argv[1], "split": "tiny", "sensors": ()}
single = gymnasium.make("ArraMon-v0", **host)
single.reset()
several = gymnasium.make_vec("ArraMon-v0", 2, **host)
several.reset()
both = two_agents.parallel_env(**host)
both.reset()
run = arramon_client.Run.create(language="en", agent="forgetful", **host)
next(run.episodes())
connection = arramon_client.connect(sys.argv[1])
connection.__enter__()
"""


@pytest.fixture
def server(tmp_path: Path) -> Iterator[Server]:
    tiny.write(tmp_path)
    server = Server(tmp_path)
    yield server
    assert server.stop() == 0


class Thing:
    """Something to close."""


def test_it_is_closed_once() -> None:
    closed: list[str] = []
    thing = Thing()
    close = close_once(thing, lambda: closed.append("thing"))
    close()
    close()
    del thing
    assert closed == ["thing"]


def test_what_is_deleted_is_closed() -> None:
    closed: list[str] = []
    thing = Thing()
    close_once(thing, lambda: closed.append("thing"))
    del thing
    assert closed == ["thing"]


def test_at_the_end_of_the_program_the_latest_is_closed_first_and_nothing_in_a_fork() -> None:
    done = subprocess.run([sys.executable, "-c", FORGETFUL], capture_output=True, text=True, timeout=120)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.splitlines() == ["second closed", "the end", "third closed", "first closed"]


def test_every_forgotten_connection_is_closed_before_python_stops_the_threads(server: Server) -> None:
    done = subprocess.run([sys.executable, "-c", DOORS, server.address], capture_output=True, text=True, timeout=120)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.split() == ["closed"] * 6
