"""Runs played step by step in an event loop, against a scripted server."""

import asyncio
from collections.abc import Iterator
from typing import Any

import pytest

from arramon_client import AsyncRun, AsyncRunEpisode, Run, RunClosedError, StepSpentError
from tests.client.fake import RUN, Recorder, Servicer, World, serving
from tests.client.runs.test_run import BY_RULE, half_played


@pytest.fixture
def address(world: World) -> Iterator[str]:
    with serving(Servicer(world)) as address:
        yield address


async def created(address: str, **options: Any) -> AsyncRun:
    return await AsyncRun.create(server=address, language="en", agent="mine", **options)


async def play_by_rule(episode: AsyncRunEpisode) -> None:
    while not episode.ended:
        seen = await episode.look()
        await episode.act(seen.step, Recorder.rule(episode.episode_id, seen.step))


@pytest.mark.parametrize("cut", [{}, {1: "before"}, {7: "after"}, {2: "after", 3: "before", 9: "after", 14: "before"}])
def test_episodes_are_played_at_once(address: str, world: World, cut: dict[int, str]) -> None:
    world.cut = cut

    async def play() -> None:
        async with await created(address, parallel=3) as run, asyncio.TaskGroup() as tasks:
            async for episode in run.episodes():
                tasks.create_task(play_by_rule(episode))
            assert (await run.wait()).state == "complete"
            assert (await run.report())["run"]["run_id"] == RUN
            scores = await episode.scores()
            assert scores is not None
            assert set(scores) == {"turn 1", "turn 2", "total"}

    asyncio.run(play())
    assert world.actions == BY_RULE


def test_a_slow_episode_holds_up_no_other(address: str, world: World) -> None:
    """The first episode waits until all others have ended."""

    async def play() -> None:
        async with await created(address, parallel=4) as run:
            found = [episode async for episode, _ in _counted(run, 4)]
            await asyncio.gather(*map(play_by_rule, found[1:]))
            assert world.actions["e0"] == []
            await play_by_rule(found[0])

    asyncio.run(play())
    assert world.actions == BY_RULE


async def _counted(run: AsyncRun, count: int) -> Any:
    number = 0
    async for episode in run.episodes():
        number += 1
        yield episode, number
        if number == count:
            return


def test_a_cancelled_act_is_taken_once(address: str, world: World) -> None:
    async def play() -> None:
        async with await created(address) as run:
            episode = await anext(run.episodes())
            await episode.look()
            with world.lock:  # The server does not answer.
                task = asyncio.create_task(episode.act(0, 1))
                while not episode.actions:
                    await asyncio.sleep(0)
                task.cancel()
                with pytest.raises(asyncio.CancelledError):
                    await task
            after = await episode.act(0, 1)
            assert (after and after.step, episode.actions) == (1, (1,))
            with pytest.raises(StepSpentError):
                await episode.act(0, 2)
            await episode.give_up("enough")
            assert (episode.ended, episode.cause) == (True, "FORFEITED")

    asyncio.run(play())
    assert world.actions["e0"] == [1]


def test_a_run_is_resumed_and_listed(address: str, world: World) -> None:
    half_played(world)

    async def play() -> None:
        assert [run.run_id for run in await AsyncRun.list(server=address)] == [RUN]
        async with await AsyncRun.resume(RUN, server=address) as run:
            episode = await anext(run.episodes())
            assert (await episode.look()).step == 3
        with pytest.raises(RunClosedError):
            await episode.look()

    asyncio.run(play())
    with Run.resume(RUN, server=address, parallel=8) as run:
        assert next(run.episodes()).look().step == 3
