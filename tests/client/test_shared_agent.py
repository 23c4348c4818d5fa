"""Streams that share an agent: an episode is played on the stream that began it last."""

import pytest

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1 import types_pb2
from arramon_client import Episode
from arramon_client.observations import observation_of
from arramon_client.plugin.failures import FailureCounter
from arramon_client.plugin.shared_agent import EpisodesTakenOver, SharedAgent, StreamAgent
from arramon_client.session import Session
from arramon_client.transport.images import ImageDecoder
from tests.client.fake import Recorder, World


class Ending(Recorder):
    def __init__(self) -> None:
        super().__init__()
        self.ended: list[str] = []

    def end(self, episode_id: str) -> None:
        self.ended.append(episode_id)


@pytest.fixture
def agent() -> Ending:
    return Ending()


@pytest.fixture
def streams(agent: Ending) -> tuple[StreamAgent, StreamAgent]:
    shared = SharedAgent(agent)
    return StreamAgent(shared), StreamAgent(shared)


def session_of(run: pb.Run, agent: StreamAgent) -> Session:
    return Session(run, agent, lambda _: None, FailureCounter(keep_going=False))


def start(session: Session, world: World, *episode_ids: str, history: bool = False) -> None:
    session.start_stream(history=history)
    for episode_id in episode_ids:
        for event in world.started(episode_id, history=history):
            session.take(event)


def ended(episode_id: str) -> pb.Event:
    return pb.Event(episode_ended=pb.EpisodeEnded(episode_id=episode_id, cause=types_pb2.CAUSE_TIME_LIMIT))


def test_an_episode_belongs_to_the_stream_that_began_it_last(
    agent: Ending, streams: tuple[StreamAgent, StreamAgent], world: World
) -> None:
    first, second = streams
    world.actions = {"e1": []}
    seen = observation_of(world.observation("e1", 0).observation, ImageDecoder())
    first.begin(Episode("e1", "en", "val_seen"))
    assert first.act([seen]) == [1]
    second.begin(Episode("e1", "en", "val_seen"))
    assert (first.plays("e1"), second.plays("e1")) == (False, True)
    with pytest.raises(EpisodesTakenOver, match="another stream plays e1"):
        first.act([seen])
    first.end("e1")
    assert (agent.ended, agent.asked) == ([], [("e1", 0)])
    second.end("e1")
    second.end("e1")
    assert (agent.ended, second.plays("e1")) == (["e1"], False)


def test_an_episode_whose_begin_raised_is_played_on_no_stream() -> None:
    class Picky(Ending):
        def begin(self, episode: Episode) -> None:
            if self.begun:
                raise RuntimeError("again")
            super().begin(episode)

    shared = SharedAgent(Picky())
    first, second = StreamAgent(shared), StreamAgent(shared)
    first.begin(Episode("e1", "en", "val_seen"))
    with pytest.raises(RuntimeError):
        second.begin(Episode("e1", "en", "val_seen"))
    assert (first.plays("e1"), second.plays("e1")) == (False, False)


def test_the_stream_that_lost_an_episode_does_not_end_it_for_the_other(
    agent: Ending, streams: tuple[StreamAgent, StreamAgent], world: World, run: pb.Run
) -> None:
    first, second = (session_of(run, each) for each in streams)
    world.actions = {"e0": [], "e1": []}
    start(first, world, "e0", "e1")
    first.answer()
    world.actions["e1"] = [1]
    start(second, world, "e1", history=True)
    first.start_stream(history=False)
    first.take(pb.Event(opened=pb.Opened(run=run, episode_ids=["e0"])))
    assert agent.ended == []
    second.answer()
    second.answer()
    assert agent.asked[-2:] == [("e1", 0), ("e1", 1)]
    second.take(ended("e1"))
    assert agent.ended == ["e1"]


def test_a_stale_observation_does_not_reach_the_agent_and_a_new_stream_is_opened(
    agent: Ending, streams: tuple[StreamAgent, StreamAgent], world: World, run: pb.Run
) -> None:
    first, second = (session_of(run, each) for each in streams)
    world.actions = {"e0": [], "e1": []}
    start(first, world, "e0", "e1")
    start(second, world, "e1")  # Before the first stream has learnt that it lost the episode.
    acts = first.answer()
    assert [(act.episode_id, act.step) for act in acts] == [("e0", 0)]
    assert (agent.asked, agent.ended, first.failures) == ([("e0", 0)], [], [])
    assert first.must_reopen
    first.start_stream(history=first.needs_history)
    assert not first.must_reopen
    assert [(act.episode_id, act.step) for act in second.answer()] == [("e1", 0)]


def test_an_episode_that_comes_back_unchanged_begins_again_as_the_agent_lost_its_state(
    agent: Ending, streams: tuple[StreamAgent, StreamAgent], world: World, run: pb.Run
) -> None:
    first, second = (session_of(run, each) for each in streams)
    world.actions = {"e1": []}
    start(first, world, "e1")
    first.answer()
    world.actions["e1"] = [1]
    start(second, world, "e1", history=True)
    second.take(pb.Event(opened=pb.Opened(run=run)))  # It has lost the episode before its first step.
    assert agent.ended == ["e1"]
    start(first, world, "e1")
    assert first.must_reopen
    start(first, world, "e1", history=True)
    assert [(act.episode_id, act.step) for act in (*first.answer(), *first.answer())] == [("e1", 1)]
    assert agent.begun == ["e1", "e1", "e1"]
    assert agent.asked == [("e1", 0), ("e1", 0), ("e1", 1)]
