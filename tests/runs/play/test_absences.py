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
from tests.runs.engines import House, Seat, looks, quick, until

pytestmark = pytest.mark.usefixtures("quick")

__all__ = ["quick"]


@pytest.fixture
def house(tmp_path: Path) -> Iterator[House]:
    house = House(tmp_path, 4)  # on SQLite, as PostgreSQL's clock is not a test's to move
    with closing(house.database):
        yield house


def play(body: Callable[[], Awaitable[None]]) -> None:
    asyncio.run(asyncio.wait_for(body(), 120))


def _gone(*_: object) -> NoReturn:
    raise StorageError("the line is cut")


def bank(house: House) -> float:
    return house.activity.bank_left("run")


@pytest.mark.parametrize(
    ("away", "connected", "charged"), [(0.0, 59.0, 0.0), (59.0, 0.0, 0.0), (40.0, 45.0, 25.0), (85.0, 0.0, 25.0)]
)
def test_it_is_the_same_whether_a_client_thinks_connected_or_not(
    house: House, away: float, connected: float, charged: float
) -> None:
    """A client that disconnects between every two actions."""
    run = house.run()

    async def body() -> None:
        async with house.engine() as engine:
            for step in range(3):
                seat = Seat(engine, run)
                assert (await seat.observation()).state.step == step
                engine.leave(seat.stream)
                house.live(away)
                seat = Seat(engine, run)
                seen = await seat.observation()
                house.live(connected)
                seat.act(seen.episode.episode_id, step, tiny.ACTIONS[step])
                await seat.observation()
                engine.leave(seat.stream)
            assert bank(house) == pytest.approx(100.0 - 3 * charged, abs=0.1)

    play(body)


def test_who_is_away_until_the_bank_is_empty_loses_the_step(house: House) -> None:
    run = house.run()

    async def body() -> None:
        async with house.engine() as engine:
            seat = Seat(engine, run)
            first = (await seat.observation()).episode.episode_id
            engine.leave(seat.stream)
            house.live(161.0)
            back = Seat(engine, run)
            seen = await back.observation()
            assert (seen.episode.episode_id, seen.time_left) == (first, TimeLeft(0.0, 0.0))
            house.live(1.0)
            ended = await back.ended()
            assert (ended.episode_id, ended.cause) == (first, "TIME_LIMIT")
            await back.play()
        assert house.causes() == {"TIME_LIMIT": 1, "AGENT_FINISHED": 3}

    play(body)


def test_a_stream_that_stays_covers_no_other_that_leaves(house: House) -> None:
    run = house.run()

    async def body() -> None:
        async with house.engine(grace=1e9) as engine:
            thinker, dummy = (
                Seat(engine, run, player="thinker", adopt=False),
                Seat(engine, run, player="dummy", adopt=False),
            )
            await thinker.observation()
            engine.leave(thinker.stream)
            for step in range(3):
                seen = await dummy.observation()
                house.live(50.0)
                dummy.act(seen.episode.episode_id, step, tiny.ACTIONS[step])
            assert bank(house) == 100.0
            await Seat(engine, run, player="thinker", adopt=False).observation()
            assert bank(house) == pytest.approx(10.0, abs=0.1)

    play(body)


def test_who_adopts_an_episode_learns_what_its_absence_cost(house: House) -> None:
    run = house.run()

    async def body() -> None:
        async with house.engine() as engine:
            gone, heir = Seat(engine, run, player="gone"), Seat(engine, run, player="heir")
            first = (await gone.observation()).episode.episode_id
            own = (await heir.observation()).episode.episode_id
            engine.leave(gone.stream)
            for step in range(2):
                house.live(50.0)
                heir.act(own, step, tiny.ACTIONS[step])
                await heir.observation()
            engine.receive(heir.stream, [Act(own, 2, forfeit="for the test")])
            seen = await heir.observation()
            assert seen.episode.episode_id == first
            assert seen.time_left is not None
            assert seen.time_left.bank_seconds == pytest.approx(60.0, abs=0.1)

    play(body)


def test_the_absence_of_many_streams_is_charged_once(house: House) -> None:
    run = house.run()

    async def body() -> None:
        async with house.engine(grace=1e9) as engine:
            seats = [Seat(engine, run, player=str(number), adopt=False) for number in range(4)]
            for seat in seats:
                await seat.observation()
            for seat in seats:
                engine.leave(seat.stream)
            house.live(70.0)
            for number in range(4):  # they come back after 70, 75, 80 and 85 seconds
                await Seat(engine, run, player=str(number), adopt=False).observation()
                house.live(5.0 if number < 3 else 0.0)
            away = 85.0 - 60.0  # and those that are back are overdue, each stream for itself
            await until(lambda: bank(house) == pytest.approx(100.0 - away - (15.0 + 10.0 + 5.0), abs=0.1))

    play(body)


def test_other_streams_that_come_and_go_erase_no_absence(house: House) -> None:
    run = house.run()

    async def body() -> None:
        async with house.engine(grace=1e9) as engine:
            thinker = Seat(engine, run, player="thinker", adopt=False)
            await thinker.observation()
            engine.leave(thinker.stream)
            for _ in range(10):
                dummy = Seat(engine, run, player="dummy", adopt=False)
                seen = await dummy.observation()
                dummy.act(seen.episode.episode_id, seen.state.step, tiny.ACTIONS[seen.state.step])
                await dummy.observation()
                engine.leave(dummy.stream)
                house.live(14.0)
            await Seat(engine, run, player="thinker", adopt=False).observation()
            assert bank(house) == pytest.approx(20.0, abs=0.1)

    play(body)


def test_reconnecting_without_reading_stops_no_clock(house: House) -> None:
    run = house.run()

    async def body() -> None:
        async with house.engine() as engine:
            seat = Seat(engine, run, episodes=2)
            await seat.observation()
            await seat.observation()
            for _ in range(5):
                engine.leave(seat.stream)
                house.live(1.0)
                seat = Seat(engine, run, episodes=2, reads=False, history=True)
                await looks(engine, 1)
                house.live(25.0)
            engine.leave(seat.stream)
            assert bank(house) == pytest.approx(100.0 - (5 * 26.0 - 60.0), abs=0.1)

    play(body)


def test_an_observation_that_was_never_sent_may_wait(house: House) -> None:
    run = house.run()

    async def body() -> None:
        async with house.engine() as engine:
            engine.leave(Seat(engine, run).stream)
            house.live(120.0)
            assert (await Seat(engine, run).observation()).time_left == TimeLeft(60.0, 100.0)

    play(body)


def test_to_change_the_process_gains_no_more_than_the_time_of_a_step(house: House) -> None:
    """A client connects to one process after the other, before it closes its stream to the last."""
    run = house.run()

    async def body() -> None:
        async with house.engine() as one, house.engine() as other:
            old = Seat(one, run)
            await old.observation()
            for engine, last in ((other, one), (one, other), (other, one)):
                house.live(40.0)
                new = Seat(engine, run)
                await new.observation()
                last.leave(old.stream)
                old = new
            house.live(40.0)
            other.leave(old.stream)
            await Seat(one, run).observation()
            assert bank(house) == pytest.approx(100.0 - (4 * 40.0 - 60.0) + 20.0, abs=0.1)

    play(body)


def test_the_death_of_a_process_costs_nothing(house: House) -> None:
    run = house.run()

    async def body() -> None:
        with closing(Database(house.url, clock=lambda: house.wall)) as line:
            async with house.engine(database=line) as one, house.engine() as other:
                dead = Seat(one, run)
                first = (await dead.observation()).episode.episode_id
                line.read = line.write = line.commit = _gone  # type: ignore[method-assign, assignment]
                house.live(1000.0)
                house.wall += LEASE + 1.0
                heir = Seat(other, run)
                seen = await heir.observation()
                assert (seen.episode.episode_id, seen.time_left) == (first, TimeLeft(60.0, 100.0))
                heir.act(first, 0, tiny.ACTIONS[0])
                await heir.play()

    play(body)
    assert house.causes() == {"AGENT_FINISHED": 4}


def test_time_bank_is_shared_between_processes(house: House) -> None:
    run = house.run()

    async def body() -> None:
        async with house.engine() as one, house.engine() as other:
            seats = [Seat(one, run, player="a"), Seat(other, run, player="b")]
            for seat in seats:
                seen = await seat.observation()
                seat.act(seen.episode.episode_id, 0, tiny.L)
                await seat.observation()
            for seat, step, seconds, told in (
                (seats[0], 1, 140.0, Observed),  # 80 seconds of a bank of 100
                (seats[1], 1, 0.0, Observed),  # and 80 more
                (seats[0], 2, 61.0, Observed),  # this process learns with what it charges what the other has
                (seats[0], 3, 61.0, EpisodeEnded),
            ):
                house.now += seconds
                seat.act(next(iter(seat.stream.sessions)), step, tiny.L)
                await seat.next(told)

    play(body)
    assert house.causes()["TIME_LIMIT"] >= 1
