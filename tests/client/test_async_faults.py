"""Agents that wait and break the contract: cancelled calls, methods that cannot be called, notes without end."""

import asyncio
import sys
from typing import Any

import pytest

from arramon.v1 import evaluation_pb2 as pb
from arramon_client import AgentError, AgentStoppedError, Answer, Observation
from arramon_client.transport.connection import Server
from tests.client.fake import Recorder, World
from tests.client.test_async_play import Waiting, no_delays, played  # noqa: F401 - a fixture
from tests.client.test_play import BY_RULE, half_played


async def wait_for_cancelled_task() -> None:
    task = asyncio.ensure_future(asyncio.sleep(9))
    task.cancel()
    await task


class Cancelling(Waiting):
    """Awaits something that was cancelled, in one of its methods, for episode e1."""

    def __init__(self, method: str, times: int = sys.maxsize) -> None:
        super().__init__()
        self.method, self.times = method, times

    async def _maybe(self, method: str, episode_id: str = "e1") -> None:
        if method == self.method and episode_id == "e1" and self.times:
            self.times -= 1
            await wait_for_cancelled_task()

    async def open(self, run: Any) -> None:
        await super().open(run)
        await self._maybe("open")

    async def begin(self, episode: Any) -> None:  # type: ignore[override]
        super().begin(episode)
        await self._maybe("begin", episode.episode_id)

    async def act(self, seen: Observation) -> Any:
        await self._maybe("act", seen.episode_id)
        return await super().act(seen)

    async def end(self, episode_id: str) -> None:
        await super().end(episode_id)
        await self._maybe("end", episode_id)


@pytest.mark.parametrize("method", ["open", "begin", "act", "end"])
def test_a_cancelled_call_is_a_failure(server: Server, run: pb.Run, method: str) -> None:
    """It must not end the episode's task silently: the run would never end."""
    with pytest.raises(AgentError, match=rf"{method}\(\) raised CancelledError"):
        played(server, run, Cancelling(method), retries=1)


def test_a_call_that_was_cancelled_once_is_repeated(server: Server, world: World, run: pb.Run) -> None:
    outcome, notices = played(server, run, Cancelling("act", times=1))
    assert (world.actions, outcome.failures, len(notices)) == (BY_RULE, (), 1)


def test_an_agent_that_cancels_its_own_task_stops_the_run(server: Server, run: pb.Run) -> None:
    class Selfish(Waiting):
        async def act(self, seen: Observation) -> Any:
            if seen.episode_id == "e1":
                task = asyncio.current_task()
                assert task is not None
                task.cancel()
            return await super().act(seen)

    with pytest.raises(AgentStoppedError, match="the task of episode e1 was cancelled"):
        played(server, run, Selfish())


def test_a_failed_replay_is_not_repeated(server: Server, world: World, run: pb.Run) -> None:
    class Forgetful(Waiting):
        replayed = 0

        def replay(self, seen: Observation, action: int) -> None:
            self.replayed += 1
            raise LookupError("no memory")

    half_played(world)
    agent = Forgetful()
    outcome, _ = played(server, run, agent, resume=True, on_failure="give-up", retries=5)
    assert agent.replayed == len(outcome.failures) == 2


class AwaitsReplay(Recorder):
    """A batch agent whose `replay` would never be awaited."""

    async def replay(self, seen: Observation, action: int) -> None: ...


class ReplaysOne(Waiting):
    """An agent whose `replay` lacks a parameter."""

    def replay(self, seen: Observation) -> None: ...


@pytest.mark.parametrize(
    ("agent", "message"),
    [
        (AwaitsReplay(), r"AwaitsReplay.replay is a coroutine function .*expected an ordinary method replay\("),
        (ReplaysOne(), r"ReplaysOne has replay\(seen: .*\) -> None; expected a method that can be called as replay\("),
    ],
)
def test_a_replay_that_cannot_be_called_is_named_before_the_run(
    server: Server, world: World, run: pb.Run, agent: Any, message: str
) -> None:
    with pytest.raises(AgentError, match=message):
        played(server, run, agent)
    assert world.opens == []


def test_a_replay_buffer_is_no_method(server: Server, world: World, run: pb.Run) -> None:
    agent = Waiting()
    agent.replay = []  # type: ignore[attr-defined]
    half_played(world)
    played(server, run, agent, resume=True)
    assert world.actions == BY_RULE


def test_a_coroutine_is_no_batch_of_actions(server: Server, run: pb.Run) -> None:
    class Wrapped(Recorder):
        def act(self, observations: Any) -> Any:
            return wait_for_cancelled_task()

    with pytest.raises(AgentStoppedError, match=r"act\(\) returned coroutine, .* `async def act\(self, observation\)`"):
        played(server, run, Wrapped())


def test_a_note_nested_too_deeply_is_a_failure(server: Server, run: pb.Run) -> None:
    note: dict[str, Any] = {}
    for _ in range(sys.getrecursionlimit()):
        note = {"a": note}

    class Deep(Waiting):
        async def act(self, seen: Observation) -> Any:
            return Answer(await super().act(seen), note)

    with pytest.raises(AgentStoppedError, match="the note cannot be written as JSON"):
        played(server, run, Deep())
