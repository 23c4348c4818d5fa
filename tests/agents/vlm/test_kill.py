"""The client is killed at moments all over a call: no answered call is paid twice, and no result is changed."""

import json
import math
import random
import signal
import threading
import time
from pathlib import Path

import pytest

from benchmarks.agents.fake_endpoint import Behaviour, FakeEndpoint, Request, Response
from tests import tiny
from tests.agents.vlm import runs
from tests.faults import clients
from tests.moments import spread_moments
from tests.serving import Server

PARALLEL = 4
"""Episodes that the client plays at a time, so calls that can be in flight."""

MARGIN = 4
"""Calls that a client may make after those that a kill waits for: or it might be at its end before it is killed."""


class Gate:
    """A behaviour that holds calls back once so many were made."""

    def __init__(self, behaviour: Behaviour) -> None:
        self._behaviour = behaviour
        self._change = threading.Condition()
        self._most: float = 0

    def allow(self, most: float) -> None:
        with self._change:
            self._most = most
            self._change.notify_all()

    def __call__(self, request: Request, number: int) -> Response:
        with self._change:
            self._change.wait_for(lambda: number < self._most)
        return self._behaviour(request, number)


@pytest.mark.parametrize("kills", [2, pytest.param(16, marks=pytest.mark.slow)])
def test_no_answered_call_is_repeated(kills: int, tmp_path: Path) -> None:
    episodes, chance = 2 + kills, random.Random(kills)
    data, output = tmp_path / "data", tmp_path / "out"
    runs.write(data, episodes)
    server = Server(data, "127.0.0.1:0", log=tmp_path / "server.log")
    gate = Gate(runs.expert(episodes, delay=0.02))
    with FakeEndpoint(gate) as fake:
        process = runs.client(server.address, fake, output)
        run_id = clients.run_id(process)
        # Anywhere in a call or between two; calls take half of this time.
        for moment in spread_moments(kills, 0.04, seed=kills):
            count = len(fake.requests) + chance.randint(1, 7)
            gate.allow(count + MARGIN)
            while len(fake.requests) < count:
                time.sleep(0.01)
            time.sleep(moment)
            process.send_signal(signal.SIGKILL)
            process.communicate()
            process = runs.client(server.address, fake, output, "--resume", run_id)
        gate.allow(math.inf)
        said, _ = process.communicate()
        assert process.returncode == 0, said
        asked = [json.dumps(request, sort_keys=True) for request in fake.requests]
    assert server.stop() == 0
    answered = runs.calls_of(output)
    assert len(set(answered)) == len(answered) == episodes * runs.CALLS + 1  # and the sight check
    in_flight = len(asked) - len(answered)  # asked before a kill, and answered to nobody
    assert in_flight <= PARALLEL * kills
    assert len(asked) - len(set(asked)) <= in_flight
    results = clients.results(output)
    assert set(results["actions"].values()) <= {"".join(map(str, tiny.ACTIONS))}
    assert [episode["cause"] for episode in results["episodes"]] == ["AGENT_FINISHED"] * episodes
    assert results["agent_report"]["measured"]["calls"] == len(answered)
