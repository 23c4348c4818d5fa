"""The client is killed at random moments: no answered call is paid twice, and the run ends as an undisturbed one."""

import json
import random
import signal
import time
from pathlib import Path

import pytest

from benchmarks.agents.fake_endpoint import FakeEndpoint
from tests import tiny
from tests.agents.vlm import runs
from tests.faults import clients
from tests.serving import Server

PARALLEL = 4
"""Episodes that the client plays at a time, so calls that can be in flight."""

PATIENCE = 3000
"""Looks for the next call, a hundredth of a second apart."""


@pytest.mark.parametrize("kills", [2, pytest.param(50, marks=pytest.mark.slow)])
def test_no_answered_call_is_repeated(kills: int, tmp_path: Path) -> None:
    episodes, chance = 2 + kills, random.Random(kills)
    data, output = tmp_path / "data", tmp_path / "out"
    runs.write(data, episodes)
    server = Server(data, "127.0.0.1:0", log=tmp_path / "server.log")
    with FakeEndpoint(runs.expert(episodes, delay=0.02)) as fake:
        process = runs.client(server.address, fake, output)
        run_id = clients.run_id(process)
        for _ in range(kills):
            wait_for_calls(fake, len(fake.requests) + chance.randint(1, 7))
            time.sleep(chance.uniform(0.0, 0.04))  # anywhere in a call or between two
            process.send_signal(signal.SIGKILL)
            process.communicate()
            process = runs.client(server.address, fake, output, "--resume", run_id)
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


def wait_for_calls(fake: FakeEndpoint, count: int) -> None:
    for _ in range(PATIENCE):
        if len(fake.requests) >= count:
            return
        time.sleep(0.01)
    raise AssertionError(f"{len(fake.requests)} calls; expected {count}")
