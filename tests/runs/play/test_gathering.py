"""Actions of one stream that arrive in many messages: applied and committed together, but none waits for long."""

import asyncio
from pathlib import Path

import pytest

from arramon_client.world import Action
from arramon_server.runs.play import engine as engines
from arramon_server.runs.play import stream as streams
from arramon_server.runs.play.events import Observed
from arramon_server.runs.play.stream import MAX_BATCH, Act
from arramon_server.runs.storage.journal import Journal
from arramon_server.runs.storage.records import CommitBatch
from tests.runs.engines import Backend, FakeStream, until

EPISODES = 8


@pytest.fixture
def commits(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """The number of steps of each commit."""
    counts: list[int] = []
    commit = Journal.commit

    def counted(self: Journal, batch: CommitBatch) -> None:
        if batch.steps:
            counts.append(len(batch.steps))
        commit(self, batch)

    monkeypatch.setattr(Journal, "commit", counted)
    return counts


def steps(fake: FakeStream) -> list[int]:
    return [event.state.step for event in fake.events if isinstance(event, Observed)]


def test_waiting_messages_share_a_commit(tmp_path: Path, commits: list[int]) -> None:
    async def play() -> None:
        backend = Backend(tmp_path, EPISODES)
        async with backend.engine() as engine:
            fake = FakeStream(engine, backend.run(), EPISODES)
            await until(lambda: steps(fake) == [0] * EPISODES)
            for episode_id in list(fake.stream.sessions):
                fake.act(episode_id, 0, Action.LEFT)
            await until(lambda: steps(fake)[EPISODES:] == [1] * EPISODES)
            assert backend.journal.progress("run").steps == EPISODES

    asyncio.run(asyncio.wait_for(play(), 60))
    assert commits == [EPISODES]


def test_messages_wait_until_half_of_the_episodes_are_answered(
    tmp_path: Path, commits: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(streams, "GATHER_SECONDS", 3600.0)

    async def play() -> None:
        backend = Backend(tmp_path, EPISODES)
        async with backend.engine() as engine:
            fake = FakeStream(engine, backend.run(), EPISODES)
            await until(lambda: steps(fake) == [0] * EPISODES)
            for episode_id in list(fake.stream.sessions)[: EPISODES // 2]:
                await asyncio.sleep(0.01)
                assert not commits
                fake.act(episode_id, 0, Action.LEFT)
            await until(lambda: steps(fake)[EPISODES:] == [1] * (EPISODES // 2))

    asyncio.run(asyncio.wait_for(play(), 60))
    assert commits == [EPISODES // 2]


def test_a_message_for_which_no_others_come_is_answered(
    tmp_path: Path, commits: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(engines, "SWEEP_SECONDS", 3600.0)  # Otherwise each sweep starts a round, too.

    async def play() -> None:
        backend = Backend(tmp_path, EPISODES)
        async with backend.engine() as engine:
            fake = FakeStream(engine, backend.run(), EPISODES)
            await until(lambda: steps(fake) == [0] * EPISODES)
            fake.act(next(iter(fake.stream.sessions)), 0, Action.LEFT)
            await until(lambda: steps(fake)[EPISODES:] == [1])

    asyncio.run(asyncio.wait_for(play(), 60))
    assert commits == [1]


def test_a_round_takes_whole_messages_up_to_a_limit(tmp_path: Path, commits: list[int]) -> None:
    async def play() -> None:
        backend = Backend(tmp_path, 1)
        async with backend.engine() as engine:
            fake = FakeStream(engine, backend.run())
            await until(lambda: steps(fake) == [0])
            (episode_id,) = fake.stream.sessions
            for first in range(0, 60, 20):  # longer than the limit, and yet applied whole
                engine.receive(fake.stream, [Act(episode_id, first + step, Action.LEFT) for step in range(20)])
            await until(lambda: steps(fake)[-1] == 60)
            assert steps(fake) == list(range(61))

    assert MAX_BATCH < 20
    asyncio.run(asyncio.wait_for(play(), 60))
    assert commits == [20, 20, 20]
