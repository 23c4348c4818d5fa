"""Instructions reach the agent as the server sends them, and are made safe where people read them."""

import json
from collections.abc import Sequence
from pathlib import Path

import pytest

from arramon.v1 import evaluation_pb2 as pb
from arramon_client import Observation, ProtocolError
from arramon_client.play import Settings, play
from arramon_client.recording.recorder import Recording
from arramon_client.transport.connection import Server
from arramon_client.transport.incoming import MAX_INSTRUCTION, check_and_clean, check_observation
from tests.client.fake import RUN, Recorder, World

ODD = "\ufeffgo\u200b to\u00ad the \u200eमेरा क्\u200dष\u200f\x1b[31m\u3164 e" + "\u0301" * 20
"""What editors and web pages leave in texts, and what a terminal would obey."""

INVISIBLE = "\ufeff\u200b\u00ad\u200e\u200f\x1b\u3164"


class Odd(World):
    """A world whose instructions are like that."""

    def observation(self, episode_id: str, step: int, taken: int | None = None) -> pb.Event:
        event = super().observation(episode_id, step, taken)
        event.observation.instruction = ODD
        return event


class Reader(Recorder):
    """An agent that keeps its instructions."""

    def __init__(self) -> None:
        super().__init__()
        self.read: set[str] = set()

    def act(self, observations: Sequence[Observation]) -> list[int]:
        self.read |= {each.instruction for each in observations}
        return super().act(observations)


@pytest.fixture
def world() -> World:
    return Odd()


def test_the_agent_gets_them_as_they_are(server: Server, run: pb.Run) -> None:
    """As in the same process, where no transport is between: scores must not depend on it."""
    reader = Reader()
    play(server.stub, run, reader, Settings(parallel=2))
    assert reader.read == {ODD}


def test_recordings_hold_them_whole_and_show_them_safely(server: Server, run: pb.Run, tmp_path: Path) -> None:
    with Recording(tmp_path, run, lambda _: None) as recording:
        play(server.stub, run, Recorder(), Settings(parallel=2), recording=recording)
    steps = (tmp_path / RUN / "e0" / "steps.jsonl").read_text(encoding="utf-8")
    assert {json.loads(line)["instruction"] for line in steps.splitlines()} == {ODD}
    page = (tmp_path / RUN / "e0" / "index.html").read_text(encoding="utf-8")
    for kept in (steps, page):
        assert "मेरा" in kept
        assert not set(INVISIBLE) & set(kept)
    assert "\\u200b" not in page
    assert "\u0301" * 9 not in page


def test_too_long_ones_are_refused() -> None:
    said = "an instruction that the server sent has 20001 characters, expected at most 20000"
    check_observation(pb.Observation(instruction="\u200b" * MAX_INSTRUCTION, turn=1))
    with pytest.raises(ProtocolError, match=said):
        check_observation(pb.Observation(instruction="\u200b" * (MAX_INSTRUCTION + 1), turn=1))


def test_their_alphabet_is_not_changed_either() -> None:
    """Instructions are compared with it."""
    info = pb.ServerInfo()
    info.splits.add(name="odd").texts["en"].alphabet = "".join(sorted(set(ODD)))
    assert check_and_clean(info).splits[0].texts["en"].alphabet == "".join(sorted(set(ODD)))
