"""Clients that disconnect, reconnect or do not read in order to gain time: the clocks of their steps run on."""

import asyncio
from collections.abc import Awaitable, Callable, Iterator
from contextlib import closing
from pathlib import Path
from typing import NoReturn

import pytest

from arramon_server.errors import StorageError
from arramon_server.runs.play.clocks import TimeLeft
from arramon_server.runs.play.events import EpisodeEnded, Observed
from arramon_server.runs.play.stream import Act
from arramon_server.runs.storage.database import Database
from arramon_server.runs.storage.records import LEASE
from tests import tiny
from tests.runs.engines import Backend, FakeStream, quick, until, wait_for_rounds

pytestmark = pytest.mark.usefixtures("quick")

__all__ = ["quick"]


@pytest.fixture
def backend(tmp_path: Path) -> Iterator[Backend]:
    backend = Backend(tmp_path, 4)  # on SQLite, as PostgreSQL's clock is not a test's to move
    with closing(backend.database):
        yield backend


def play(body: Callable[[], Awaitable[None]]) -> None:
    asyncio.run(asyncio.wait_for(body(), 120))


def _gone(*_: object) -> NoReturn:
    raise StorageError("the line is cut")


def bank(backend: Backend) -> float:
    return backend.activity.bank_left("run")


@pytest.mark.parametrize(
    ("away", "connected", "charged"), [(0.0, 59.0, 0.0), (59.0, 0.0, 0.0), (40.0, 45.0, 25.0), (85.0, 0.0, 25.0)]
)
def test_it_is_the_same_whether_a_client_thinks_connected_or_not(
    backend: Backend, away: float, connected: float, charged: float
) -> None:
    """A client that disconnects between every two actions."""
    run = backend.run()

    async def body() -> None:
        async with backend.engine() as engine:
            for step in range(3):
                fake = FakeStream(engine, run)
                assert (await fake.observation()).state.step == step
                engine.leave(fake.stream)
                backend.live(away)
                fake = FakeStream(engine, run)
                seen = await fake.observation()
                backend.live(connected)
                fake.act(seen.episode.episode_id, step, tiny.ACTIONS[step])
                await fake.observation()
                engine.leave(fake.stream)
            assert bank(backend) == pytest.approx(100.0 - 3 * charged, abs=0.1)

    play(body)


def test_who_is_away_until_the_bank_is_empty_loses_the_step(backend: Backend) -> None:
    run = backend.run()

    async def body() -> None:
        async with backend.engine() as engine:
            fake = FakeStream(engine, run)
            first = (await fake.observation()).episode.episode_id
            engine.leave(fake.stream)
            backend.live(161.0)
            back = FakeStream(engine, run)
            seen = await back.observation()
            assert (seen.episode.episode_id, seen.time_left) == (first, TimeLeft(0.0, 0.0))
            backend.live(1.0)
            ended = await back.ended()
            assert (ended.episode_id, ended.cause) == (first, "TIME_LIMIT")
            await back.play()
        assert backend.causes() == {"TIME_LIMIT": 1, "AGENT_FINISHED": 3}

    play(body)


def test_a_stream_that_stays_covers_no_other_that_leaves(backend: Backend) -> None:
    run = backend.run()

    async def body() -> None:
        async with backend.engine(grace=1e9) as engine:
            thinker, dummy = (
                FakeStream(engine, run, player="thinker", adopt=False),
                FakeStream(engine, run, player="dummy", adopt=False),
            )
            await thinker.observation()
            engine.leave(thinker.stream)
            for step in range(3):
                seen = await dummy.observation()
                backend.live(50.0)
                dummy.act(seen.episode.episode_id, step, tiny.ACTIONS[step])
            assert bank(backend) == 100.0
            await FakeStream(engine, run, player="thinker", adopt=False).observation()
            assert bank(backend) == pytest.approx(10.0, abs=0.1)

    play(body)


def test_who_adopts_an_episode_learns_what_its_absence_cost(backend: Backend) -> None:
    run = backend.run()

    async def body() -> None:
        async with backend.engine() as engine:
            gone, heir = FakeStream(engine, run, player="gone"), FakeStream(engine, run, player="heir")
            first = (await gone.observation()).episode.episode_id
            own = (await heir.observation()).episode.episode_id
            engine.leave(gone.stream)
            for step in range(2):
                backend.live(50.0)
                heir.act(own, step, tiny.ACTIONS[step])
                await heir.observation()
            engine.receive(heir.stream, [Act(own, 2, forfeit="for the test")])
            seen = await heir.observation()
            assert seen.episode.episode_id == first
            assert seen.time_left is not None
            assert seen.time_left.bank_seconds == pytest.approx(60.0, abs=0.1)

    play(body)


def test_the_absence_of_many_streams_is_charged_once(backend: Backend) -> None:
    run = backend.run()

    async def body() -> None:
        async with backend.engine(grace=1e9) as engine:
            fakes = [FakeStream(engine, run, player=str(number), adopt=False) for number in range(4)]
            for fake in fakes:
                await fake.observation()
            for fake in fakes:
                engine.leave(fake.stream)
            backend.live(70.0)
            for number in range(4):  # they come back after 70, 75, 80 and 85 seconds
                await FakeStream(engine, run, player=str(number), adopt=False).observation()
                backend.live(5.0 if number < 3 else 0.0)
            away = 85.0 - 60.0  # and those that are back are overdue, each stream for itself
            await until(lambda: bank(backend) == pytest.approx(100.0 - away - (15.0 + 10.0 + 5.0), abs=0.1))

    play(body)


def test_other_streams_that_come_and_go_erase_no_absence(backend: Backend) -> None:
    run = backend.run()

    async def body() -> None:
        async with backend.engine(grace=1e9) as engine:
            thinker = FakeStream(engine, run, player="thinker", adopt=False)
            await thinker.observation()
            engine.leave(thinker.stream)
            for _ in range(10):
                dummy = FakeStream(engine, run, player="dummy", adopt=False)
                seen = await dummy.observation()
                dummy.act(seen.episode.episode_id, seen.state.step, tiny.ACTIONS[seen.state.step])
                await dummy.observation()
                engine.leave(dummy.stream)
                backend.live(14.0)
            await FakeStream(engine, run, player="thinker", adopt=False).observation()
            assert bank(backend) == pytest.approx(20.0, abs=0.1)

    play(body)


def test_reconnecting_without_reading_stops_no_clock(backend: Backend) -> None:
    run = backend.run()

    async def body() -> None:
        async with backend.engine() as engine:
            fake = FakeStream(engine, run, episodes=2)
            await fake.observation()
            await fake.observation()
            for _ in range(5):
                engine.leave(fake.stream)
                backend.live(1.0)
                fake = FakeStream(engine, run, episodes=2, reads=False, history=True)
                await wait_for_rounds(engine, 1)
                backend.live(25.0)
            engine.leave(fake.stream)
            assert bank(backend) == pytest.approx(100.0 - (5 * 26.0 - 60.0), abs=0.1)

    play(body)


def test_an_observation_that_was_never_sent_may_wait(backend: Backend) -> None:
    run = backend.run()

    async def body() -> None:
        async with backend.engine() as engine:
            engine.leave(FakeStream(engine, run).stream)
            backend.live(120.0)
            assert (await FakeStream(engine, run).observation()).time_left == TimeLeft(60.0, 100.0)

    play(body)


def test_to_change_the_process_gains_no_more_than_the_time_of_a_step(backend: Backend) -> None:
    """A client connects to one process after the other, before it closes its stream to the last."""
    run = backend.run()

    async def body() -> None:
        async with backend.engine() as one, backend.engine() as other:
            old = FakeStream(one, run)
            await old.observation()
            for engine, last in ((other, one), (one, other), (other, one)):
                backend.live(40.0)
                new = FakeStream(engine, run)
                await new.observation()
                last.leave(old.stream)
                old = new
            backend.live(40.0)
            other.leave(old.stream)
            await FakeStream(one, run).observation()
            assert bank(backend) == pytest.approx(100.0 - (4 * 40.0 - 60.0) + 20.0, abs=0.1)

    play(body)


def test_the_death_of_a_process_costs_nothing(backend: Backend) -> None:
    run = backend.run()

    async def body() -> None:
        with closing(Database(backend.url, clock=lambda: backend.wall)) as line:
            async with backend.engine(database=line) as one, backend.engine() as other:
                dead = FakeStream(one, run)
                first = (await dead.observation()).episode.episode_id
                line.read = line.write = line.commit = _gone  # type: ignore[method-assign, assignment]
                backend.live(1000.0)
                backend.wall += LEASE + 1.0
                heir = FakeStream(other, run)
                seen = await heir.observation()
                assert (seen.episode.episode_id, seen.time_left) == (first, TimeLeft(60.0, 100.0))
                heir.act(first, 0, tiny.ACTIONS[0])
                await heir.play()

    play(body)
    assert backend.causes() == {"AGENT_FINISHED": 4}


def test_time_bank_is_shared_between_processes(backend: Backend) -> None:
    run = backend.run()

    async def body() -> None:
        async with backend.engine() as one, backend.engine() as other:
            fakes = [FakeStream(one, run, player="a"), FakeStream(other, run, player="b")]
            for fake in fakes:
                seen = await fake.observation()
                fake.act(seen.episode.episode_id, 0, tiny.L)
                await fake.observation()
            for fake, step, seconds, event_type in (
                (fakes[0], 1, 140.0, Observed),  # 80 seconds of a bank of 100
                (fakes[1], 1, 0.0, Observed),  # and 80 more
                (fakes[0], 2, 61.0, Observed),  # this process learns with what it charges what the other has
                (fakes[0], 3, 61.0, EpisodeEnded),
            ):
                backend.now += seconds
                fake.act(next(iter(fake.stream.sessions)), step, tiny.L)
                await fake.next(event_type)

    play(body)
    assert backend.causes()["TIME_LIMIT"] >= 1
