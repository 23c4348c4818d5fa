"""Copies of an agent in processes of their own: calls, images, failures, and a run over several streams."""

import json
import os
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from arramon_client.agent import Answer, Episode, Observation
from arramon_client.errors import StopRun
from arramon_client.plugin import agent_calls, agent_process
from arramon_client.plugin.agent_calls import ReportedAgentError
from arramon_client.plugin.agent_process import AgentProcess, agent_processes, choose_processes

AGENT = """
import os
from arramon_client.agent import Answer
from arramon_client.errors import StopRun

class Agent:
    def __init__(self, plus=0):
        self.plus, self.kept, self.replayed = plus, {}, []

    def begin(self, episode):
        self.kept[episode.episode_id] = []

    def act(self, observations):
        for each in observations:
            self.kept[each.episode_id].append(each.rgb)
            if each.instruction == "fail":
                raise ValueError("no way")
            if each.instruction == "stop":
                raise StopRun("enough", "max_calls")
            if each.instruction == "die":
                os._exit(7)
        first = [int(self.kept[each.episode_id][0].sum()) for each in observations]
        note = lambda each: {"pid": os.getpid(), "depth": each.depth is not None and float(each.depth.sum()),
                             "replayed": self.replayed, "writeable": each.rgb.flags.writeable}
        return [Answer((one + self.plus) % 4, note(each)) for one, each in zip(first, observations)]

    def replay(self, observation, action):
        self.replayed.append([int(observation.rgb.sum()), action])

    def end(self, episode_id):
        del self.kept[episode_id]
"""


@pytest.fixture
def file(tmp_path: Path) -> str:
    path = tmp_path / "copied_agent.py"
    path.write_text(AGENT)
    return str(path)


@pytest.fixture
def agent(file: str) -> Iterator[AgentProcess]:
    process = AgentProcess(file, {"plus": 1}, replays=True)
    process.begin(Episode("e1", "en", "val_seen"))
    yield process
    process.stop()


def seen(value: int, instruction: str = "go", episode_id: str = "e1", size: int = 4) -> Observation:
    return Observation(
        episode_id=episode_id,
        turn=1,
        phase="navigation",
        step=0,
        instruction=instruction,
        phase_step=0,
        steps_left=9,
        rgb=np.full((size, size, 3), value, np.uint8),
        depth=np.full((size, size), 0.5, np.float32),
    )


def note_of(answer: Answer) -> dict[str, Any]:
    """Return a note, which is stored as JSON."""
    assert isinstance(answer.note, str)
    found: dict[str, Any] = json.loads(answer.note)
    return found


def test_calls_reach_the_process_and_its_agent_may_keep_images(agent: AgentProcess) -> None:
    agent.begin(Episode("e2", "en", "val_seen"))
    (one,) = agent.act([seen(1)])
    both = agent.act([seen(2), seen(3, episode_id="e2")])
    assert [each.action for each in (one, *both)] == [(48 + 1) % 4, (48 + 1) % 4, (3 * 48 + 1) % 4]
    note = note_of(one)
    assert note["pid"] != os.getpid()
    assert (note["depth"], note["writeable"]) == (8.0, False)
    agent.end("e2")
    with pytest.raises(ReportedAgentError, match=r"end\(\) raised KeyError"):
        agent.end("e2")


def test_images_beyond_the_shared_memory_are_sent_too(agent: AgentProcess, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(agent_process, "MEMORY", 100)
    (answer,) = agent.act([seen(3)])
    assert answer.action == (3 * 48 + 1) % 4
    assert note_of(answer)["depth"] == 8.0


def test_recorded_steps_are_replayed(agent: AgentProcess) -> None:
    assert agent.replay is not None
    agent.replay(replace(seen(1), taken=2), 2)
    (answer,) = agent.act([seen(1)])
    assert note_of(answer)["replayed"] == [[48, 2]]


def test_a_failure_is_described_as_without_a_process(agent: AgentProcess) -> None:
    with pytest.raises(ReportedAgentError, match=r"^act\(\) raised ValueError: no way$") as caught:
        agent_calls.act(agent, [seen(1, "fail")])
    assert 'raise ValueError("no way")' in caught.value.details
    assert agent.act([seen(1)])[0].action == 1


def test_an_agent_can_stop_the_run(agent: AgentProcess) -> None:
    with pytest.raises(StopRun, match="enough") as caught:
        agent_calls.act(agent, [seen(1, "stop")])
    assert caught.value.limit == "max_calls"


def test_the_end_of_a_process_stops_the_run(agent: AgentProcess) -> None:
    with pytest.raises(StopRun, match="exit code 7"):
        agent_calls.act(agent, [seen(1, "die")])


def test_an_agent_that_cannot_be_loaded_is_reported(tmp_path: Path) -> None:
    with (
        agent_processes(2, object(), str(tmp_path / "none.py"), {}) as copies,
        pytest.raises(ReportedAgentError, match="there is no file"),
    ):
        copies[0].begin(Episode("e1", "en", "val_seen"))


class Copied:
    uses_processes = True


@pytest.mark.parametrize(
    ("agent", "requested", "parallel", "episodes", "expected"),
    [
        (object(), None, 8, None, 1),
        (object(), 3, 8, None, 3),
        (object(), 9, 8, None, 8),
        (object(), 9, None, None, 9),
        (Copied(), None, 8, None, 2),
        (Copied(), None, None, None, 6),
        (Copied(), None, None, 9, 2),
        (Copied(), None, 64, 12, 3),
        (Copied(), None, 3, None, 1),
        (Copied(), None, 8, 2, 1),
        (Copied(), 1, 8, None, 1),
    ],
)
def test_number_of_processes(
    agent: object,
    requested: int | None,
    parallel: int | None,
    episodes: int | None,
    expected: int,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(agent_process, "usable_cores", lambda: 6)
    assert choose_processes(agent, requested, parallel, episodes) == expected


def test_one_process_is_the_clients_own() -> None:
    with agent_processes(1, object(), "no.such.agent", {}) as copies:
        assert copies == []
