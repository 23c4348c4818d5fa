"""The agent's optional method `end`: when it is called, when it is not, and what happens if it fails."""

from collections.abc import Sequence
from typing import Any

import pytest

from arramon.v1 import evaluation_pb2 as pb
from arramon.v1 import types_pb2
from arramon_client import AgentError, AgentStoppedError, Settings, play
from arramon_client.plugin.failures import FailureCounter
from arramon_client.session import Session
from arramon_client.transport.connection import Server
from tests.client.fake import Recorder, World

EPISODES = ["e0", "e1", "e2", "e3"]


class Ending(Recorder):
    """A recorder that has `end`, and checks the guaranteed order.

    Attributes:
        open: episodes that have begun and not ended.
        ended: episodes, in order.
    """

    def __init__(self) -> None:
        super().__init__()
        self.open: set[str] = set()
        self.ended: list[str] = []

    def begin(self, episode: Any) -> None:
        assert episode.episode_id not in self.open
        super().begin(episode)
        self.open.add(episode.episode_id)

    def act(self, observations: Sequence[Any]) -> list[int]:
        assert self.open >= {each.episode_id for each in observations}
        return super().act(observations)

    def end(self, episode_id: str) -> None:
        self.open.remove(episode_id)
        self.ended.append(episode_id)


def session_of(run: pb.Run, agent: Any) -> Session:
    return Session(run, agent, lambda _: None, FailureCounter(keep_going=True))


def take(session: Session, events: Sequence[pb.Event]) -> None:
    for event in events:
        session.take(event)


def ended(episode_id: str, cause: types_pb2.Cause.ValueType = types_pb2.CAUSE_TIME_LIMIT) -> pb.Event:
    return pb.Event(episode_ended=pb.EpisodeEnded(episode_id=episode_id, cause=cause))


@pytest.mark.parametrize(
    "cut", [{}, {1: "before"}, {7: "after"}, {20: "after"}, {2: "after", 3: "before", 15: "after"}]
)
@pytest.mark.parametrize("parallel", [1, 3, 4])
def test_each_episode_ends_once_after_its_last_step(
    server: Server, world: World, run: pb.Run, parallel: int, cut: dict[int, str]
) -> None:
    world.cut = cut
    agent = Ending()
    play(server.stub, run, agent, Settings(parallel=parallel))
    assert (agent.begun, sorted(agent.ended), agent.open) == (EPISODES, EPISODES, set())


@pytest.mark.parametrize("cause", [
    types_pb2.CAUSE_AGENT_FINISHED, types_pb2.CAUSE_STEP_LIMIT, types_pb2.CAUSE_TIME_LIMIT, types_pb2.CAUSE_FORFEITED,
    types_pb2.CAUSE_SERVER_FAULT,
])  # fmt: skip
def test_every_cause_ends_an_episode_and_a_repeated_event_does_not(
    world: World, run: pb.Run, cause: types_pb2.Cause.ValueType
) -> None:
    agent = Ending()
    session = session_of(run, agent)
    world.actions = {"e0": []}
    take(session, [*world.started("e0", history=False), ended("e0", cause), ended("e0", cause), ended("e1", cause)])
    assert (agent.begun, agent.ended) == (["e0"], ["e0"])


def test_an_episode_that_the_agent_fails_is_ended_when_it_is_given_up(
    server: Server, world: World, run: pb.Run
) -> None:
    class Failing(Ending):
        def act(self, observations: Sequence[Any]) -> list[int]:
            if observations[0].episode_id == "e1":
                raise RuntimeError("lost")
            return super().act(observations)

    agent = Failing()
    play(server.stub, run, agent, Settings(parallel=1))
    assert (set(world.reasons), agent.ended) == ({"e1"}, EPISODES)


def test_an_episode_whose_begin_raised_is_not_ended(server: Server, run: pb.Run) -> None:
    class Picky(Ending):
        def begin(self, episode: Any) -> None:
            if episode.episode_id == "e2":
                raise RuntimeError("not this one")
            super().begin(episode)

    agent = Picky()
    play(server.stub, run, agent, Settings(parallel=1))
    assert agent.ended == ["e0", "e1", "e3"]


def test_episodes_that_were_begun_by_another_client_are_ended_after_a_resume(
    server: Server, world: World, run: pb.Run
) -> None:
    world.actions = {"e0": [0, 1, 2], "e1": [1]}
    world.players = {"e0": "another", "e1": "another"}
    agent = Ending()
    play(server.stub, run, agent, Settings(parallel=4, resume=True))
    assert (sorted(agent.ended), agent.open) == (EPISODES, set())


def test_an_episode_lost_to_another_player_is_ended_and_begins_again_if_it_comes_back(
    world: World, run: pb.Run
) -> None:
    agent = Ending()
    session = session_of(run, agent)
    world.actions = {"e0": [], "e1": []}
    session.start_stream(history=False)
    take(session, [*world.started("e0", history=False), *world.started("e1", history=False)])
    session.answer()
    session.start_stream(history=False)
    take(session, [pb.Event(opened=pb.Opened(run=run, episode_ids=["e1"]))])
    assert (agent.ended, agent.open) == (["e0"], {"e1"})
    world.actions["e0"] = [0, 3]  # Another player took the second step.
    session.start_stream(history=True)
    take(session, [pb.Event(opened=pb.Opened(run=run, episode_ids=["e0", "e1"]))])
    take(session, world.started("e0", history=True))
    assert (agent.begun, agent.ended, agent.open) == (["e0", "e1", "e0"], ["e0"], {"e0", "e1"})


def test_an_episode_that_another_player_continued_is_ended_before_it_begins_again(world: World, run: pb.Run) -> None:
    agent = Ending()
    session = session_of(run, agent)
    world.actions = {"e0": []}
    take(session, world.started("e0", history=False))
    session.answer()
    world.actions["e0"] = [0, 1, 2]
    session.start_stream(history=True)
    take(session, world.started("e0", history=True))
    assert (agent.begun, agent.ended) == (["e0", "e0"], ["e0"])


def test_a_problem_that_takes_an_episode_away_ends_it(world: World, run: pb.Run) -> None:
    agent = Ending()
    session = session_of(run, agent)
    world.actions = {"e0": []}
    problem = pb.Problem(code=pb.Problem.CODE_NOT_YOUR_EPISODE, message="no", episode_id="e0")
    take(session, [*world.started("e0", history=False), pb.Event(problem=problem)])
    assert agent.ended == ["e0"]


def test_the_end_of_a_run_ends_its_open_episodes(world: World, run: pb.Run) -> None:
    agent = Ending()
    session = session_of(run, agent)
    world.actions = {"e1": [], "e0": []}
    take(session, [event for episode_id in world.actions for event in world.started(episode_id, history=False)])
    take(session, [pb.Event(run_ended=pb.RunEnded(run=run))])
    assert (agent.ended, session.ended) == (["e0", "e1"], True)


class Stuck(Ending):
    """Fails at the end of some episodes."""

    def __init__(self, episodes: Sequence[str]) -> None:
        super().__init__()
        self.episodes = episodes

    def end(self, episode_id: str) -> None:
        super().end(episode_id)
        if episode_id in self.episodes:
            raise KeyError("no such memory")


@pytest.mark.parametrize(("failing", "keep_going"), [(["e1"], False), (["e1", "e3"], False), (EPISODES, True)])
def test_a_failure_of_end_is_reported_and_gives_up_no_episode(
    server: Server, world: World, run: pb.Run, failing: list[str], keep_going: bool
) -> None:
    notices: list[str] = []
    settings = Settings(parallel=1, keep_going=keep_going)
    outcome = play(server.stub, run, Stuck(failing), settings, notify=notices.append)
    said = "end() raised KeyError: 'no such memory'"
    assert notices == [f"the agent failed, but no episode is given up: {said}"]
    assert [(each.episode_ids, each.message) for each in outcome.failures] == [((), said)] * len(failing)
    assert 'raise KeyError("no such memory")' in outcome.failures[0].details
    assert (world.reasons, set(world.causes.values())) == ({}, {types_pb2.CAUSE_AGENT_FINISHED})
    assert outcome.run.state == pb.RUN_STATE_COMPLETE


def test_an_end_that_fails_three_times_in_a_row_stops_the_run(server: Server, world: World, run: pb.Run) -> None:
    with pytest.raises(
        AgentStoppedError, match=r"^run stopped: the agent failed in 3 episodes in a row: end\(\) raised"
    ):
        play(server.stub, run, Stuck(["e0", "e1", "e2"]), Settings(parallel=1))
    assert world.reasons == {}


def test_an_end_that_is_none_is_not_called(server: Server, run: pb.Run) -> None:
    class Without(Recorder):
        end = None

    assert play(server.stub, run, Without(), Settings(parallel=2)).failures == ()


def test_an_end_that_cannot_be_called_is_refused_before_anything_is_played(
    server: Server, world: World, run: pb.Run
) -> None:
    class Wrong(Recorder):
        def end(self) -> None:
            raise AssertionError

    with pytest.raises(
        AgentError, match=r"Wrong has end\(\).*expected a method that can be called as end\(episode_id\)"
    ):
        play(server.stub, run, Wrong(), Settings(parallel=2))
    assert world.opens == []
