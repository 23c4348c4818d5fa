"""A run played over several server processes, each with a stream of its own."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest

from arramon.v1 import evaluation_pb2 as pb
from arramon_client import AgentStoppedError, Episode, Observation, Settings, connect
from arramon_client.multi_stream import play_streams
from arramon_client.plugin.agent_process import agent_processes
from tests import tiny
from tests.api.player import create
from tests.serving import METADATA, Server

FAILURES = 3


@pytest.fixture
def server(tmp_path: Path) -> Iterator[Server]:
    tiny.write(tmp_path / "data", count=8)
    server = Server(tmp_path / "data", f"unix:{tmp_path}/s", "--workers", "2")
    yield server
    assert server.stop() == 0


class Player:
    """Agent that plays the ground truth, but fails at the third step of its first episodes, three by default."""

    def __init__(self, failures: int) -> None:
        self.failures = failures
        self.open: set[str] = set()

    def begin(self, episode: Episode) -> None:
        self.open.add(episode.episode_id)

    def end(self, episode_id: str) -> None:
        self.open.remove(episode_id)

    def act(self, observations: Sequence[Observation]) -> list[int]:
        if self.failures and any(seen.step == 2 for seen in observations):
            self.failures -= 1
            raise ValueError("no weights")
        return [tiny.ACTIONS[seen.step] for seen in observations]


def test_all_streams_stop_if_the_agent_fails_repeatedly(server: Server) -> None:
    notices: list[str] = []
    with connect(server.address) as connected:
        assert len(connected.info.addresses) == 2
        run = create(connected.stub)
        with pytest.raises(AgentStoppedError, match="in 3 episodes in a row"):
            play_streams(connected, run, Player(FAILURES), Settings(parallel=2), notify=notices.append)
        left = connected.stub.GetRun(pb.GetRunRequest(run_id=run.run_id), metadata=METADATA)
        assert left.state == pb.RUN_STATE_RUNNING
        assert set(left.causes) <= {"FORFEITED"}
        assert [notice for notice in notices if "connection" in notice] == []
        player = Player(0)
        outcome = play_streams(connected, run, player, Settings(parallel=2, resume=True))
    assert player.open == set()
    assert outcome.run.causes["AGENT_FINISHED"] >= 6
    assert set(outcome.run.causes) <= {"AGENT_FINISHED", "FORFEITED"}


COPIED = """
import os
from arramon_client.agent import Answer
from tests import tiny

class Agent:
    def begin(self, episode):
        pass

    def act(self, observations):
        return [Answer(tiny.ACTIONS[each.step], str(os.getpid())) for each in observations]
"""


@pytest.mark.parametrize("workers", [1, 2])
def test_copies_of_an_agent_play_at_the_same_time(tmp_path: Path, workers: int) -> None:
    tiny.write(tmp_path / "data", count=8)
    file = tmp_path / "copied_player.py"
    file.write_text(COPIED)
    server = Server(tmp_path / "data", f"unix:{tmp_path}/s", "--workers", str(workers))
    with connect(server.address) as connected, agent_processes(2, Player(0), str(file), {}) as copies:
        run = create(connected.stub)
        outcome = play_streams(connected, run, Player(0), Settings(parallel=4), copies=copies)
        assert outcome.run.causes == {"AGENT_FINISHED": 8}
        assert {tuple(map(int, taken)) for taken in outcome.actions.values()} == {tuple(map(int, tiny.ACTIONS))}
        listed = connected.stub.ListNotes(pb.ListNotesRequest(run_id=run.run_id), metadata=METADATA)
        assert len({note.text for note in listed.notes}) == 2  # Both processes have played.
    assert server.stop() == 0
